// A run that is saved and goes on from the saved state is the run that was never saved, to the last bit.
#include <regex>

#include "core/parallel.hpp"
#include "support/from_toml.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

struct Continued {
  std::string name;
  std::string text;
  int steps = 60;
  friend void PrintTo(const Continued& of, std::ostream* to) { *to << of.name; }
};

constexpr const char* k_block = R"(
[grid]
upper = [1, 1]
cells = [10, 10]
[time]
end = 1
[[body]]
name = "block"
region = { type = "box", lower = [0.3, 0.1], upper = [0.6, 0.3] }
velocity = { type = "uniform", value = [0.7, -1] }
)";

constexpr const char* k_loads =
    "[[load]]\nbody = \"block\"\nkind = \"pressure\"\npressure = 500\nside = \"top\"\ntimes = [0, 0.3]\nfactors = [1, 0]\n"
    "[[load]]\nbody = \"block\"\nkind = \"force\"\nforce = [20, 10]\n";

std::vector<Continued> continued() {
  const std::string block = k_block;
  const std::string solid =
      "layout = { type = \"per_cell\", count = 4 }\nmaterial = { type = \"neo_hookean\", density = 1000, youngs_modulus = 1e5, "
      "poissons_ratio = 0.3 }\n";
  const std::string elastic = "material = { type = \"neo_hookean\", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }\n";
  const std::string water =
      "layout = { type = \"per_cell\", count = 4 }\nmaterial = { type = \"newtonian_fluid\", density = 1000, viscosity = 0.01, "
      "pressure_scale = 2000 }\n";
  const std::string sand =
      "layout = { type = \"per_cell\", count = 4 }\nmaterial = { type = \"mohr_coulomb\", density = 1600, youngs_modulus = 1e6, "
      "poissons_ratio = 0.3, cohesion = 10, friction_angle = 30, dilatancy_angle = 5 }\n";
  const std::string metal =
      "layout = { type = \"per_cell\", count = 4 }\nmaterial = { type = \"j2\", density = 1000, youngs_modulus = 1e6, poissons_ratio = "
      "0.3, "
      "yield_stress = 5e3, saturation_stress = 8e3, saturation_rate = 10 }\n";
  const auto of_law = [](const std::string& material) {
    return "layout = { type = \"per_cell\", count = 4 }\nmaterial = " + material + "\n";
  };
  const std::string clay = of_law(
                               "{ type = \"cam_clay\", density = 1700, shear_modulus = 3e5, critical_slope = 1, lambda_star = 0.1, "
                               "kappa_star = 0.02, preconsolidation = 1e3, pressure_offset = 1e2 }") +
                           "initial_stress = { type = \"geostatic\", K0 = 0.6, surcharge = 100, overconsolidation = 1.2 }\n";
  const std::string polymer = of_law(
      "{ type = \"viscoelastic\", density = 1000, bulk_modulus = 1e6, shear_modulus = 1e4, modulus_1 = 2e5, "
      "time_1 = 0.01, modulus_2 = 1e5, time_2 = 0.1 }");
  const std::string ice = of_law(
      "{ type = \"rankine_damage\", density = 900, youngs_modulus = 1e7, poissons_ratio = 0.3, "
      "tensile_strength = 1e3, fracture_energy = 0.1 }");
  const std::string falling = "velocity = { type = \"uniform\", value = [0, -100] }\n";
  const std::string floor = "[[boundary]]\nside = \"bottom\"\nkind = \"fixed\"\n";
  const std::string walls = floor + "[[boundary]]\nside = \"right\"\nkind = \"slip\"\n";
  const std::string implicit = "[solver]\ntype = \"implicit\"\n";
  const auto step = [](Real dt) { return fmt::format("[time]\nend = 1\ndt = {}\n", dt); };
  const std::string given = "gravity = [0, -9.81]\n[grid]\nupper = [1, 1]\ncells = [10, 10]\n";
  const auto box = [](const std::string& name, const char* lower, const char* upper, const std::string& more) {
    return fmt::format("[[body]]\nname = \"{}\"\nregion = {{ type = \"box\", lower = {}, upper = {} }}\n{}", name, lower, upper, more);
  };
  const std::string thrown = "velocity = { type = \"uniform\", value = [0.7, -1] }\n";
  const std::string resting = box("block", "[0.3, 0]", "[0.6, 0.3]", solid);
  const std::string two = box("lower", "[0.2, 0.0]", "[0.8, 0.2]", solid) + box("upper", "[0.35, 0.21]", "[0.65, 0.4]", solid + thrown);
  return {
      {"defaults_floor", block + solid + floor},
      {"floor_with_friction", block + solid + floor + "contact = \"friction\"\nfriction = 0.3\n"},
      {"usf_floor_with_friction", given + "[time]\nend = 1\n" + resting + "velocity = { type = \"uniform\", value = [0.7, 0] }\n" + floor +
                                      "contact = \"friction\"\nfriction = 0.3\n[solver]\nstress_order = \"usf\"\n"},
      {"floor_that_lets_go", block + solid + floor + "contact = \"no_tension\"\n"},
      {"water_with_correction", block + water + walls, 120},
      {"pairs_with_friction_usf",
       given + "[time]\nend = 1\n" + two + floor + "[solver]\ncontact = \"pairs\"\nfriction = 0.3\nstress_order = \"usf\"\n", 170},
      {"pairs_that_part", given + "[time]\nend = 1\n" + two + floor + "[solver]\ncontact = \"pairs\"\nfriction = 0.3\n", 330},
      {"pairs_with_friction", given + "[time]\nend = 1\n" + two + floor + "[solver]\ncontact = \"pairs\"\nfriction = 0.3\n"},
      {"fields_with_friction_usf",
       given + "[time]\nend = 1\n" + two + floor + "[solver]\ncontact = \"multi_field\"\nfriction = 0.3\nstress_order = \"usf\"\n"},
      {"periodic", given + "periodic = [\"x\"]\n[time]\nend = 1\n" + box("block", "[0.6, 0.1]", "[0.95, 0.3]", solid + thrown) + floor},
      {"removed", given + "particles_outside = \"remove\"\n[time]\nend = 1\n" + box("block", "[0.7, 0.1]", "[0.95, 0.3]", solid + thrown),
       100},
      {"region",
       block + water + "[[boundary]]\nregion = { type = \"box\", lower = [0.7, 0], upper = [0.9, 0.3] }\nkind = \"slip\"\n" + walls, 150},
      {"sand", given + "[time]\nend = 1\n" + box("block", "[0.3, 0]", "[0.6, 0.3]", sand + thrown) + floor, 150},
      {"sand_in_single_precision",
       given + "[time]\nend = 1\n[solver]\nprecision = \"single\"\n" + box("block", "[0.3, 0]", "[0.6, 0.3]", sand + thrown) + floor, 150},
      {"metal", block + metal + floor, 200},
      {"snow", given + "[time]\nend = 1\n" + box("block", "[0.3, 0.2]", "[0.6, 0.5]", of_law("\"snow_dry\"") + thrown) + floor, 200},
      {"hot_copper", given + "[time]\nend = 1\n" + box("block", "[0.3, 0.02]", "[0.6, 0.3]", of_law("\"copper_ofhc\"") + falling) + floor,
       150},
      {"clay", given + "[time]\nend = 1\n" + box("block", "[0.3, 0]", "[0.6, 0.3]", clay) + floor, 150},
      {"polymer", given + "[time]\nend = 1\n" + box("block", "[0.3, 0.02]", "[0.6, 0.3]", polymer + thrown) + floor, 150},
      {"ice", given + "[time]\nend = 1\n" + box("block", "[0.3, 0.02]", "[0.6, 0.3]", ice + thrown) + floor, 150},
      {"air",
       given + "[time]\nend = 1\n" + box("block", "[0, 0]", "[1, 0.9]", of_law("\"air\"")) + walls +
           "[[boundary]]\nside = \"left\"\nkind = \"slip\"\n[[boundary]]\nside = \"top\"\nkind = \"slip\"\n",
       40},
      {"rubber", block + of_law("\"rubber_treloar\"") + floor, 150},
      {"implicit_clay", given + step(0.002) + implicit + box("block", "[0.3, 0]", "[0.6, 0.3]", clay) + floor, 8},
      {"implicit_polymer", given + step(0.002) + implicit + box("block", "[0.3, 0]", "[0.6, 0.3]", polymer + thrown) + floor, 8},
      {"implicit_ice", given + step(0.002) + implicit + box("block", "[0.3, 0]", "[0.6, 0.3]", ice + thrown) + floor, 8},
      {"implicit_metal", given + step(0.002) + implicit + box("block", "[0.3, 0]", "[0.6, 0.3]", metal + thrown) + floor, 8},
      {"implicit_splines", given + step(0.002) + implicit + resting + floor, 8},
      {"implicit_bounce",
       given + step(0.002) + implicit + box("block", "[0.3, 0.02]", "[0.6, 0.3]", solid + thrown) + floor + "contact = \"no_tension\"\n",
       20},
      {"implicit_bounce_on_nodes",
       given + step(0.002) + implicit + box("block", "[0.3, 0.1]", "[0.6, 0.3]", solid + thrown) + floor +
           "contact = \"friction\"\nfriction = 0.3\n",
       24},
      {"implicit_piston",
       given + step(0.002) + implicit + resting +
           "[[boundary]]\nside = \"bottom\"\nkind = \"velocity\"\nvelocity = [0, 0.5]\ncontact = \"no_tension\"\n",
       12},
      {"implicit_pairs", given + step(0.002) + implicit + "contact = \"pairs\"\nfriction = 0.3\n" + two + floor, 16},
      {"implicit_pairs_static",
       given + step(0.1) + implicit + "mode = \"static\"\ncontact = \"pairs\"\nfriction = 0.3\n" +
           box("lower", "[0.2, 0.0]", "[0.8, 0.5]", solid) + box("upper", "[0.35, 0.5]", "[0.65, 1.0]", solid) + floor +
           "[[boundary]]\nside = \"top\"\nkind = \"velocity\"\nvelocity = [0.02, -0.03]\n",
       6},
      {"implicit_slide_on_nodes",
       given + step(0.005) + implicit + resting + "velocity = { type = \"uniform\", value = [0.7, 0] }\n" + floor +
           "contact = \"friction\"\nfriction = 0.1\n",
       30},
      {"implicit_static", given + step(0.1) + implicit + "mode = \"static\"\n" + resting + floor, 6},
      {"implicit_rule",
       given + "[time]\nend = 1\nrule = { type = \"newton_count\", first = 0.001, smallest = 1e-5, largest = 0.01 }\n" + implicit +
           resting + floor,
       8},
      {"implicit_3d",
       "dim = 3\ngravity = [0, 0, -9.81]\n[grid]\nupper = [1, 1, 1]\ncells = [5, 5, 5]\n" + step(0.005) + implicit +
           "[[body]]\nname = \"block\"\nregion = { type = \"box\", lower = [0.2, 0.2, 0.02], upper = [0.6, 0.6, 0.4] }\n"
           "layout = { type = \"per_cell\", count = 8 }\nvelocity = { type = \"uniform\", value = [0.5, 0.2, -0.5] }\n" +
           elastic + "[[boundary]]\nside = \"front\"\nkind = \"fixed\"\ncontact = \"no_tension\"\n",
       12},
      {"implicit_elements",
       given + step(0.002) + implicit + "basis = \"element\"\n" + box("plate", "[0, 0]", "[1, 0.2]", "method = \"elements\"\n" + elastic) +
           box("block", "[0.3, 0.2]", "[0.6, 0.5]", solid) + floor,
       8},
      {"rings_around_an_axis",
       "gravity = [0, -9.81]\n[grid]\naxisymmetric = true\nupper = [1, 1]\ncells = [10, 10]\n[time]\nend = 1\n" +
           box("block", "[0, 0.1]", "[0.5, 0.6]", solid + thrown) + floor,
       40},
      {"loads",
       "base_acceleration = [[0, 0], [5, 1]]\nbase_acceleration_times = [0, 0.1]\n" + given + "[time]\nend = 1\n" +
           box("block", "[0.3, 0.1]", "[0.6, 0.3]", solid + thrown) + k_loads + floor,
       60},
      {"loads_usf",
       given + "[time]\nend = 1\n[solver]\nstress_order = \"usf\"\n" + box("block", "[0.3, 0.1]", "[0.6, 0.3]", solid + thrown) + k_loads +
           floor,
       60},
      {"implicit_loads", given + step(0.002) + implicit + box("block", "[0.3, 0.1]", "[0.6, 0.3]", solid + thrown) + k_loads, 8},
      {"implicit_loads_and_bounce",
       given + step(0.002) + implicit + box("block", "[0.3, 0.02]", "[0.6, 0.3]", solid + thrown) + k_loads + floor +
           "contact = \"no_tension\"\n",
       20},
      {"tools",
       given + "[time]\nend = 1\n" + box("block", "[0.3, 0.12]", "[0.6, 0.3]", solid + thrown) +
           "[[tool]]\nname = \"upper\"\nshape = { type = \"disk\", center = [0.45, 0.4], radius = 0.1 }\ndensity = 500\nfriction = "
           "0.3\nvelocity "
           "= [0.2, -3]\nangular_velocity = 3\n[[tool]]\nname = \"plate\"\nshape = { type = \"box\", lower = [0, 0.05], upper = [0.9, 0.1] "
           "}\nvelocity = [0, 0.1]\nfriction = 0.2\n",
       80},
      {"tool_on_a_hinge",
       given + "[time]\nend = 1\n[solver]\nstress_order = \"usf\"\n" + box("block", "[0.3, 0.12]", "[0.6, 0.3]", solid + thrown) +
           "[[tool]]\nname = \"plate\"\nshape = { type = \"box\", lower = [0.2, 0.05], upper = [0.9, 0.1] }\nhinge = [0.2, 0.1]\nmass = "
           "10\nspring = "
           "1e4\nfriction = 0.2\n",
       80},
      {"implicit_elements_in_contact",
       given + step(0.002) + implicit + "basis = \"element\"\nelement_order = 1\ncontact = \"pairs\"\nfriction = 0.3\n" +
           box("plate", "[0, 0]", "[1, 0.2]", "method = \"elements\"\n" + elastic) +
           box("block", "[0.3, 0.2]", "[0.6, 0.5]", solid + thrown) + floor,
       8},
      {"implicit_bounce_of_elements",
       given + step(0.002) + implicit + "basis = \"element\"\n" +
           box("block", "[0.3, 0.1]", "[0.6, 0.3]", "method = \"elements\"\n" + elastic + thrown) + floor + "contact = \"no_tension\"\n",
       24},
  };
}

class ContinuedRun : public testing::TestWithParam<Continued> {};

TEST_P(ContinuedRun, is_the_uninterrupted_run_to_the_last_bit) {
  const Continued& of = GetParam();
  set_thread_count(1);
  Simulation whole(read(of.text));
  StateTable saved;
  for (int k = 0; k < of.steps; ++k) {
    if (k == of.steps / 2) saved = whole.save_state();
    whole.step();
  }
  set_thread_count(3);
  Simulation second(read(of.text));
  second.load_state(saved);
  EXPECT_EQ(difference_of(saved, second.save_state()), "") << "what was loaded is not what was saved";
  while (second.step_count() < of.steps) second.step();
  set_thread_count(0);
  EXPECT_EQ(difference_of(whole.save_state(), second.save_state()), "");
  for (std::size_t b = 0; b < whole.solver().body_count(); ++b) {
    for (const std::string& name : whole.solver().field_names(b))
      EXPECT_EQ(whole.solver().field(b, name).values, second.solver().field(b, name).values) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(all, ContinuedRun, testing::ValuesIn(continued()), [](const auto& parameter) { return parameter.param.name; });

/// "simulation/solver/body/lower/velocity" is of the same declaration as that of another body: "simulation/solver/body/*/velocity".
std::string declaration_of(const std::string& path) {
  return std::regex_replace(
      path, std::regex("/(block|lower|upper|plate|[0-9]+|(block|lower|upper)\\|(block|lower|upper))(?=/|$)|/grid(_of_[a-z]+)?(?=/)"), "/*");
}

/// With another value of what a state has, the next steps are others; what is there for reports alone is listed.
TEST(State, has_nothing_that_decides_nothing) {
  std::set<std::string> all, deciding;
  for (const Continued& of : continued()) {
    Simulation whole(read(of.text));
    for (int k = 0; k < of.steps / 2; ++k) whole.step();
    const StateTable saved = whole.save_state();
    // What is loaded stays where no step reads it; so the two tables are compared without the thing itself.
    const auto after = [&](const StateTable& table) {
      Simulation sim(read(of.text));
      sim.load_state(table);
      sim.step();
      sim.step();
      return sim.save_state();
    };
    const StateTable right = after(saved);
    for (const auto& [name, array] : saved) {
      StateTable other = saved;
      const bool is_changed = std::visit(
          [](auto& values) {
            using Value = typename std::decay_t<decltype(values)>::value_type;
            if constexpr (std::is_floating_point_v<Value>) {
              for (Value& value : values) value = value == 0 || !std::isfinite(value) ? Value(1e-3) : value * Value(1.001);
              return !values.empty();
            }
            return false;  // whole numbers are counts and choices: another one may not fit
          },
          other.at(name));
      if (!is_changed) continue;
      all.insert(declaration_of(name));
      try {
        if (!difference_of(after(other), right).empty()) deciding.insert(declaration_of(name));
      } catch (const std::exception&) {
        deciding.insert(declaration_of(name));  // so much that nothing goes on
      }
    }
  }
  EXPECT_GT(deciding.size(), 60u);
  std::vector<std::string> idle;
  std::set_difference(all.begin(), all.end(), deciding.begin(), deciding.end(), std::back_inserter(idle));
  // What outputs show of the last step; where escapes are looked for on a background that moves; what functions of time are asked with, of
  // which these cases have none; what springs that let go are booked with; what a step without balanced
  // accelerations starts from; the affine part of particles that are mapped already; and boxes that may be a little wider.
  const std::set<std::string> reports = {"simulation/solver/*/moved_mass",
                                         "simulation/solver/body/*/affine_velocity",
                                         "simulation/solver/*/velocity_x",
                                         "simulation/solver/*/velocity_y",
                                         "simulation/solver/background_nodes",
                                         "simulation/solver/pair/*/totals/force",
                                         "simulation/solver/pairs/body/*/box_lower",
                                         "simulation/solver/pairs/body/*/box_upper",
                                         "simulation/solver/pairs/pair/*/first/holds/energy",
                                         "simulation/solver/pairs/pair/*/second/holds/energy",
                                         "simulation/solver/boundary/*/force",
                                         "simulation/solver/load/*/force",
                                         "simulation/solver/tools/*/totals/force",
                                         "simulation/solver/loads/load/*/force",
                                         "simulation/solver/boundary/*/in_slip/force",
                                         "simulation/solver/time"};
  std::erase_if(idle, [&](const std::string& name) { return reports.count(name) > 0; });
  EXPECT_EQ(fmt::format("{}", fmt::join(idle, " ")), "");
}

TEST(State, of_another_case_is_refused_with_the_difference) {
  const std::string solid =
      "layout = { type = \"per_cell\", count = 4 }\nmaterial = { type = \"neo_hookean\", density = 1000, youngs_modulus = 1e5, "
      "poissons_ratio = 0.3 }\n";
  Simulation one(read(k_block + solid));
  const StateTable saved = one.save_state();
  const auto load_into = [&](const std::vector<std::string>& sets, const StateTable& table) {
    return complaint_of([&] { Simulation(read(k_block + solid, sets)).load_state(table); });
  };
  EXPECT_EQ(load_into({}, saved), "");
  EXPECT_EQ(load_into({"body.block.name=ball"}, saved), "the state does not fit: simulation/solver/body/ball/block_first_cell is missing");
  EXPECT_EQ(load_into({"solver.precision=single"}, saved),
            "the state does not fit: simulation/solver/body/block/block_particle_counts has not one row for each block");
  EXPECT_EQ(load_into({"solver.transfer=apic"}, saved), "the state does not fit: simulation/solver/body/block/affine_velocity is missing");
  StateTable more = saved;
  more["simulation/solver/pairs/energy"] = std::vector<double>{0};
  EXPECT_EQ(load_into({}, more), "the state does not fit: simulation/solver/pairs/energy is nothing that this case has");
  StateTable less = saved;
  std::get<std::vector<double>>(less.at("simulation/solver/body/block/velocity")).pop_back();
  EXPECT_NE(load_into({}, less).find("simulation/solver/body/block/velocity has "), std::string::npos);
}

}  // namespace
}  // namespace matpoint::test
