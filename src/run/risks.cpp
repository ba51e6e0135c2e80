#include "run/risks.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "core/error.hpp"
#include "material/initial_state.hpp"
#include "run/make_solver.hpp"

namespace matpoint {
namespace {

/// What a body has in a cell of the grid.
struct CellShare {
  Index cell = 0;
  Real volume = 0;  ///< [m^dim], of rings that of their section.
  Index count = 0;  ///< Particles.
};

/// The cells that a body fills, ascending.
std::vector<CellShare> shares_of(const Case& problem, const Solver& solver, std::size_t body) {
  const auto dim = static_cast<std::size_t>(solver.dim());
  const GridGeometry& grid = solver.grid();
  std::vector<CellShare> shares;
  {
    const std::vector<Real> volume = solver.field(body, "volume").values;
    const std::vector<Real> x = solver.field(body, "position").values;
    shares.reserve(volume.size());
    for (std::size_t p = 0; p < volume.size(); ++p) {
      Index cell = 0;
      for (std::size_t d = dim; d-- > 0;) {
        const Real place = (x[p * dim + d] - grid.lower[d]) / grid.cell_size[d];
        cell = cell * (grid.nodes[d] + 1) + static_cast<Index>(std::max(place, Real{0}));
      }
      const Real around = problem.grid.is_axisymmetric ? 2 * std::numbers::pi * x[p * dim] : 1;
      shares.push_back({cell, volume[p] / around, 1});
    }
  }
  std::sort(shares.begin(), shares.end(), [](const CellShare& a, const CellShare& b) { return a.cell < b.cell; });
  std::size_t kept = 0;
  for (std::size_t i = 1; i < shares.size(); ++i) {
    if (shares[i].cell == shares[kept].cell) {
      shares[kept].volume += shares[i].volume;
      ++shares[kept].count;
    } else {
      shares[++kept] = shares[i];
    }
  }
  if (!shares.empty()) shares.resize(kept + 1);
  return shares;
}

Real cell_volume(const Solver& solver) {
  Real volume = 1;
  for (std::size_t d = 0; d < static_cast<std::size_t>(solver.dim()); ++d) volume *= solver.grid().cell_size[d];
  return volume;
}

/// Two bodies in one place. Bodies that only touch share cells that are full; a layout may overfill those by a little.
void find_overlaps(const Solver& solver, const std::vector<std::vector<CellShare>>& shares, std::vector<std::string>& risks) {
  constexpr Real k_overfull = 1.25;  // of a cell
  constexpr Real k_share = 0.01;     // of the smaller body's volume
  const Real cell = cell_volume(solver);
  const auto sum = [](const std::vector<CellShare>& all) {
    Real volume = 0;
    for (const CellShare& one : all) volume += one.volume;
    return volume;
  };
  for (std::size_t a = 0; a < shares.size(); ++a) {
    for (std::size_t b = a + 1; b < shares.size(); ++b) {
      Real in_both = 0;
      auto other = shares[b].begin();
      for (const CellShare& one : shares[a]) {
        while (other != shares[b].end() && other->cell < one.cell) ++other;
        if (other == shares[b].end()) break;
        if (other->cell == one.cell && one.volume + other->volume > k_overfull * cell) in_both += one.volume + other->volume - cell;
      }
      if (in_both <= k_share * std::min(sum(shares[a]), sum(shares[b]))) continue;
      risks.push_back(
          fmt::format("bodies \"{}\" and \"{}\" overlap at the start: {:.2g} {} are filled by both; the same place cannot hold two bodies, "
                      "move one or cut its region with \"difference\"",
                      solver.body_name(a), solver.body_name(b), in_both, solver.dim() == 2 ? "m^2" : "m^3"));
    }
  }
}

/// Linear shapes with one particle in most cells: gaps open between particles, and stresses jump when one changes its cell.
void find_sparse_bodies(const Case& problem, const Solver& solver, const std::vector<std::vector<CellShare>>& shares,
                        std::vector<std::string>& risks) {
  constexpr Real k_sparse = 1.5;  // particles per cell
  if (problem.solver.shape != ShapeKind::linear) return;
  for (std::size_t b = 0; b < solver.body_count(); ++b) {
    if (problem.bodies[b].formulation == Formulation::total) continue;
    const auto particles = static_cast<Real>(solver.particle_count(b));
    const auto cells = static_cast<Real>(shares[b].size());
    constexpr Real k_few = 4;  // a single particle, or a handful, is no continuum
    if (particles <= k_few || particles >= k_sparse * cells) continue;
    risks.push_back(fmt::format(
        "body \"{}\" has {:.2g} particle{} in a cell, too few for shape = \"linear\": it may come apart and gain energy; give it {} "
        "(layout count), or take shape = \"bspline2\"",
        solver.body_name(b), particles / cells, particles > cells ? "s" : "", solver.dim() == 2 ? 4 : 8));
  }
}

/// A node with next to no mass, as linear shapes have where a body has just reached a cell, is thrown by any force: its velocity is
/// harmless to the particle that it weighs next to nothing for, but not its share of the velocity gradient.
void find_unsafe_schemes(const Case& problem, const Solver& solver, std::vector<std::string>& risks) {
  const SolverSpec& scheme = problem.solver;
  const bool all_total = std::all_of(problem.bodies.begin(), problem.bodies.end(),
                                     [](const BodySpec& body) { return body.formulation == Formulation::total; });
  constexpr Real k_careful = 0.1;  // of the stable step: the published examples with USL take steps as short as that
  const bool is_careful = problem.time.dt && *problem.time.dt <= k_careful * solver.stable_dt();
  if (scheme.shape == ShapeKind::linear && !all_total && !is_careful) {
    if (scheme.transfer == Transfer::apic || scheme.transfer == Transfer::tpic) {
      risks.push_back(
          fmt::format("transfer = \"{}\" with shape = \"linear\" is unstable where a node has next to no mass; take shape = \"bspline2\", "
                      "or transfer = "
                      "\"flip\"",
                      scheme.transfer == Transfer::apic ? "apic" : "tpic"));
    } else if (scheme.stress_order == StressOrder::usl) {
      risks.push_back(
          "stress_order = \"usl\" with shape = \"linear\" is unstable where a node has next to no mass; take stress_order = \"usf\" or "
          "\"musl\", or shape = \"bspline2\"");
    }
  }
  for (const BodySpec& body : problem.bodies) {
    if (!body.material->breaks() || scheme.shape != ShapeKind::cpdi || body.formulation == Formulation::total) continue;
    risks.push_back(fmt::format(
        "body \"{}\" may break, and with shape = \"cpdi\" the domains of broken particles grow over whole bodies; take shape = \"gimp\"",
        body.name));
  }
  for (const BodySpec& body : problem.bodies) {
    if (!body.has_fbar() || !scheme.fluid_correction.value_or(false)) continue;
    if (!body.material->is_fluid() || body.formulation == Formulation::total) continue;
    risks.push_back(fmt::format(
        "body \"{}\": fbar does nothing with solver.fluid_correction, which smooths the pressure of fluids; leave it out", body.name));
  }
  if (scheme.stress_order == StressOrder::musl && scheme.damping > 0) {
    risks.push_back(fmt::format(
        "stress_order = \"musl\" with damping drifts away from the state of rest; use stress_order = \"{}\" for damped problems",
        scheme.shape == ShapeKind::linear ? "usf" : "usl"));
  }
}

/// A total Lagrangian body keeps its place in the reference configuration: what it does not touch at the start it never meets.
void find_walls_that_do_not_hold(const Case& problem, const Solver& solver, std::vector<std::string>& risks) {
  const GridGeometry& grid = solver.grid();
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) {
    const BodySpec& body = problem.bodies[b];
    if (body.formulation != Formulation::total) continue;
    const BodyTotals totals = solver.totals(b);
    for (const BoundarySpec& boundary : problem.boundaries) {
      if (boundary.side.empty()) continue;
      const BoundarySide side = side_of(boundary.side);
      const auto d = static_cast<std::size_t>(side.axis);
      const Real upper = grid.lower[d] + (grid.nodes[d] - 1) * grid.cell_size[d];
      const Real gap = side.is_upper ? upper - totals.upper[d] : totals.lower[d] - grid.lower[d];
      if (gap < 2 * grid.cell_size[d]) continue;
      risks.push_back(
          fmt::format("body \"{}\" has formulation = \"total\": the side \"{}\", {:.3g} m from it at the start, will not stop it; take "
                      "formulation = \"updated\"",
                      body.name, boundary.side, gap));
    }
  }
}

/// Stresses at the start that the material cannot carry: it flows in the first step.
void find_stresses_that_yield(const Case& problem, const Solver& solver, std::vector<std::string>& risks) {
  constexpr Real k_yields = 1e-6;
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) {
    const BodySpec& body = problem.bodies[b];
    if (!body.initial_stress || !body.material->has_state()) continue;
    const auto dim = static_cast<std::size_t>(problem.dim);
    const std::vector<Real> x = solver.field(b, "position").values;
    std::map<std::array<Real, 6>, Real> known;
    Index count = 0;
    Real worst = 0;
    Vec3 where{};
    for (std::size_t p = 0; dim * p < x.size(); ++p) {
      Vec3 place{};
      std::copy_n(x.begin() + static_cast<std::ptrdiff_t>(dim * p), dim, place.begin());
      const std::array<Real, 6> stress = body.initial_stress->at(place);
      const auto [at, is_new] = known.emplace(stress, 0);
      if (is_new) {
        const InitialState state = initial_state(*body.material, problem.dim, stress, body.initial_stress->overconsolidation);
        at->second = yields_by(*body.material, problem.dim, state);
      }
      if (at->second <= k_yields) continue;
      ++count;
      if (at->second <= worst) continue;
      worst = at->second;
      where = place;
    }
    if (count == 0) continue;
    risks.push_back(
        fmt::format("body \"{}\": its initial stress is beyond the yield surface of \"{}\" at {} of {} particles, most at [{:.4g}], where "
                    "it loses {:.2g} "
                    "% at once; take K0 nearer to 1, or a stronger material",
                    body.name, body.material->type(), count, solver.particle_count(b),
                    fmt::join(where.begin(), where.begin() + problem.dim, ", "), 100 * worst));
  }
}

/// How far the start is from equilibrium, where it was meant to be in it: one step of another solver tells.
void find_start_out_of_balance(const Case& problem, const Solver& solver, std::vector<std::string>& risks) {
  constexpr Real k_balanced = 0.05;  // of gravity: the rows at a surface and at a wall are out of balance by less
  const Real g = std::sqrt(std::inner_product(problem.gravity.begin(), problem.gravity.end(), problem.gravity.begin(), Real{0}));
  bool is_meant = g > 0 && problem.gravity_times.empty();
  for (const BodySpec& body : problem.bodies) is_meant = is_meant && body.initial_stress && !body.velocity;
  if (!is_meant) return;
  Index count = 0;
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) count += solver.particle_count(b);
  constexpr Index k_most = 10'000'000;  // the other solver takes as much memory as this one
  if (count > k_most) return;
  const std::unique_ptr<Solver> trial = make_solver(problem);
  const Real dt = 0.1 * trial->stable_dt();
  trial->step(0, dt);
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) {
    const BodyTotals totals = trial->totals(b);
    // Of the particles, and not of the body: what pushes to both sides is out of balance, too.
    const Real acceleration = std::sqrt(2 * totals.kinetic_energy / totals.mass) / (dt * g);
    if (acceleration <= k_balanced) continue;
    risks.push_back(fmt::format(
        "body \"{}\" starts out of balance: its initial stress leaves {:.2g} of gravity in the mean; take type = \"geostatic\" for all "
        "bodies, hold its "
        "sides (kind = \"slip\"), or leave the stress out",
        solver.body_name(b), acceleration));
  }
}

/// Tools that the grid sees through: particles before and behind them share nodes.
void find_thin_tools(const Case& problem, std::vector<std::string>& risks) {
  constexpr int k_samples = 60;  // along each side of a tool's box
  constexpr Real k_cells = 2;
  for (const ToolSpec& tool : problem.tools) {
    const Vec3 lower = tool.shape->lower(), upper = tool.shape->upper();
    if (!std::all_of(lower.begin(), lower.begin() + problem.dim, [](Real x) { return std::isfinite(x); })) continue;
    // Twice the greatest depth; faces, and so middles of boxes, are on the samples' lattice.
    Real depth = 0, cell = std::numeric_limits<Real>::infinity();
    std::array<int, 3> count{1, 1, 1};
    for (std::size_t d = 0; d < static_cast<std::size_t>(problem.dim); ++d) {
      count[d] = k_samples + 1;
      cell = std::min(cell, problem.grid.cell_size[d]);
    }
    for (int i = 0; i < count[0]; ++i) {
      for (int j = 0; j < count[1]; ++j) {
        for (int k = 0; k < count[2]; ++k) {
          const std::array<int, 3> place{i, j, k};
          Vec3 x{};
          for (std::size_t d = 0; d < static_cast<std::size_t>(problem.dim); ++d)
            x[d] = lower[d] + place[d] * (upper[d] - lower[d]) / k_samples;
          depth = std::max(depth, -tool.shape->surface_near(x, problem.dim)->distance);
        }
      }
    }
    if (2 * depth >= k_cells * cell * (1 - 1e-9)) continue;
    risks.push_back(fmt::format(
        "tool \"{}\" is {:.3g} m thick, less than two cells of {:.3g} m: what is before it drags what is behind it, and particles that "
        "hit it fast may pass; make it thicker, or the cells smaller",
        tool.name, 2 * depth, cell));
  }
}

}  // namespace

std::vector<std::string> risks_of(const Case& problem, const Solver& solver) {
  std::vector<std::string> risks;
  find_stresses_that_yield(problem, solver, risks);
  if (problem.is_implicit()) return risks;
  find_start_out_of_balance(problem, solver, risks);
  std::vector<std::vector<CellShare>> shares;
  for (std::size_t b = 0; b < solver.body_count(); ++b) shares.push_back(shares_of(problem, solver, b));
  find_overlaps(solver, shares, risks);
  find_sparse_bodies(problem, solver, shares, risks);
  find_unsafe_schemes(problem, solver, risks);
  find_walls_that_do_not_hold(problem, solver, risks);
  find_thin_tools(problem, risks);
  return risks;
}

}  // namespace matpoint
