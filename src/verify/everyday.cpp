// What a newcomer writes first: bodies, materials, walls and loads, and nothing numerical. Each problem runs with the defaults and with
// each `quality`; what is right follows from mechanics or from independent programs (docs/verification.md, "Everyday cases").
#include "verify/everyday.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace matpoint {
namespace {

const std::vector<EverydaySetting> k_settings = {
    {"default", {}}, {"robust", {"solver.quality=robust"}}, {"accurate", {"solver.quality=accurate"}}, {"fast", {"solver.quality=fast"}}};

/// Rows that settings miss today; they are printed as goals. Whatever mends one takes it out of here.
bool is_missed(const std::string& quantity) {
  for (const char* name : {
           "books_bar",    // 1.8 % of the energy where 1 % is asked for: what MUSL loses beside the impulses
           "ball_stress",  // .16 to .19 of the root mean square where .15 is asked for
           "long_box_pressure",
           "cube_centre",           // .1234 m where .1224 is asked for: it still sloshes
           "box_pressure",          // .03 to .08 of rho g H where .05 is asked for: the second row of nodes has 9 % too little
           "fine_ball_lowest",      // .1016 to .1018 m where .1013 is asked for
           "dam_front_difference",  // 1.4 % to c = 1483 m/s where 1 % is asked for; 0.3 % to 200 m/s
       }) {
    if (quantity.starts_with(name)) return true;
  }
  // 1.4e-6 m in single precision; and .1035 m, .0002 beyond the bound, with steps of a quarter, which show the error of the cells alone.
  // In single precision still water sinks by 8 % in 20 s.
  // On 8 cells in its height FLIP shakes the stretched skin of the long cantilever until it tears with the default step (19 to 22 pieces
  // after 3 s); the run says so (the health of a run: noise), and solver.transfer = "apic" does not.
  if (quantity.starts_with("fine_cantilever") && (quantity.ends_with("default") || quantity.ends_with("fast"))) return true;
  return quantity == "sliding_region_spread_fast" || quantity == "ball_lowest_robust" || quantity == "long_still_centre_fast";
}

/// To see what a setting chooses.
const char* const k_smallest = R"(
[grid]
upper = [1, 1]
cells = [4, 4]
[time]
end = 1
[[body]]
name = "b"
region = { type = "box", lower = [0.25, 0.25], upper = [0.75, 0.75] }
layout = { type = "per_cell", count = 4 }
material = { type = "neo_hookean", density = 1, youngs_modulus = 1, poissons_ratio = 0 }
)";

}  // namespace

Case everyday_case(const std::string& text, const EverydaySetting& setting, Sets sets) {
  sets.insert(sets.end(), setting.sets.begin(), setting.sets.end());
  Input input = parse_toml(text, "everyday");
  for (const std::string& set : sets) apply_set(input, set);
  return Case::from_input(input, "everyday");
}

Real total_energy(const Simulation& sim) {
  const Ledger& ledger = sim.solver().ledger();
  return energy(sim) + ledger.contact_energy - ledger.boundary_work - ledger.body_force_work;
}

Range run_with_energy(Simulation& sim) {
  Range range;
  const Real start = total_energy(sim);
  sim.add_callback([&](const Simulation& now) {
    range.include(total_energy(now) / start);
    return true;
  });
  sim.run();
  return range;
}

Measured with_prefix(const std::string& prefix, const Measured& measured) {
  Measured renamed;
  for (const auto& [name, value] : measured) renamed[prefix + name] = value;
  return renamed;
}

int pieces(const Simulation& sim, std::size_t body, Real distance) {
  const std::vector<Real> x = sim.solver().field(body, "position").values;
  const std::size_t n = x.size() / 2;
  std::vector<bool> is_seen(n, false);
  int count = 0;
  for (std::size_t first = 0; first < n; ++first) {
    if (is_seen[first]) continue;
    ++count;
    std::vector<std::size_t> open{first};
    is_seen[first] = true;
    while (!open.empty()) {
      const std::size_t p = open.back();
      open.pop_back();
      for (std::size_t q = 0; q < n; ++q) {
        if (is_seen[q] || std::hypot(x[2 * p] - x[2 * q], x[2 * p + 1] - x[2 * q + 1]) > distance) continue;
        is_seen[q] = true;
        open.push_back(q);
      }
    }
  }
  return count;
}

void add_everyday(VerifySuite& suite, const Sets& numerics) {
  std::vector<EverydayProblem> problems;
  for (const auto& some : {everyday_motion(), everyday_walls(), everyday_solids(), everyday_fluids(), everyday_frames()})
    problems.insert(problems.end(), some.begin(), some.end());
  const std::vector<EverydaySetting> settings = numerics.empty() ? k_settings : std::vector<EverydaySetting>{{"given", numerics}};
  for (const EverydayProblem& problem : problems) {
    VerifyJob job{"everyday", problem.name, "everyday", problem.is_quick, true, problem.cost, {}, {}};
    std::vector<std::pair<EverydaySetting, std::vector<VerifyRow>>> by_setting;
    std::vector<VerifyRow> all;
    for (const EverydaySetting& setting : settings) {
      const bool is_single = everyday_case(k_smallest, setting).solver.precision == "single";
      by_setting.emplace_back(setting, problem.rows(is_single));
      for (VerifyRow& row : by_setting.back().second) {
        row.quantity += "_" + setting.name;
        if (setting.name != "given" && is_missed(row.quantity)) row.kind = RowKind::goal;
        all.push_back(row);
      }
    }
    job.run = [run = problem.run, by_setting] {
      Measured measured;
      for (const auto& [setting, rows] : by_setting) {
        try {
          for (const auto& [name, value] : run(setting)) measured[name + "_" + setting.name] = value;
        } catch (const SolverError&) {
          // A run that breaks off has missed its goals; where anything must hold, the job fails.
          const bool must_hold = std::any_of(rows.begin(), rows.end(), [](const VerifyRow& row) { return row.kind == RowKind::accept; });
          if (must_hold && setting.name != "given") throw;
          for (const VerifyRow& row : rows) measured[row.quantity] = std::numeric_limits<Real>::quiet_NaN();
        }
      }
      return measured;
    };
    add_problem(suite, job, all);
  }
}

}  // namespace matpoint
