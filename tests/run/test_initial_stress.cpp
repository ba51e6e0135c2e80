// Bodies that start with a stress: layers under their own weight stay at rest, what cannot be is refused, what is doubtful is said.
#include "case/case_file.hpp"
#include "support/from_toml.hpp"
#include "support/solver_case.hpp"
#include "support/temporary_folder.hpp"

namespace matpoint::test {
namespace {

const char* const k_layers = R"(
gravity = [0, -10]
[grid]
upper = [1, 4]
cells = [4, 16]
[time]
end = 0.1
[[body]]
name = "lower"
region = { type = "box", lower = [0, 0], upper = [1, 1] }
layout = { type = "per_cell", count = 4 }
initial_stress = { type = "geostatic", K0 = 0.5 }
material = { type = "drucker_prager", density = 2000, youngs_modulus = 1e7, poissons_ratio = 0.3, cohesion = 1e3, friction_angle = 30 }
[[body]]
name = "upper"
region = { type = "box", lower = [0, 1], upper = [1, 3] }
layout = { type = "per_cell", count = 4 }
initial_stress = { type = "geostatic", K0 = 0.6, surcharge = 0 }
material = { type = "neo_hookean", density = 1500, youngs_modulus = 1e7, poissons_ratio = 0.3 }
[[boundary]]
side = "left"
kind = "slip"
[[boundary]]
side = "right"
kind = "slip"
[[boundary]]
side = "bottom"
kind = "slip"
)";

Case read(const std::string& text, const std::vector<std::string>& sets = {}) {
  Input input = parse_toml(text, "case.toml");
  for (const std::string& set : sets) apply_set(input, set);
  return Case::from_input(input, "case");
}
std::string complaint(const std::vector<std::string>& sets) {
  return complaint_of([&] { Simulation{read(k_layers, sets)}; });
}
bool has_warning(const std::vector<std::string>& sets, const std::string& phrase) {
  for (const std::string& text : Simulation(read(k_layers, sets)).warnings()) {
    if (text.find(phrase) != std::string::npos) return true;
  }
  return false;
}

TEST(InitialStress, geostatic_is_the_weight_above_and_its_share_across) {
  const Simulation sim(read(k_layers));
  for (std::size_t b = 0; b < 2; ++b) {
    const std::vector<Real> x = sim.solver().field(b, "position").values, stress = sim.solver().field(b, "stress").values;
    for (std::size_t p = 0; 2 * p < x.size(); ++p) {
      const Real y = x[2 * p + 1];
      const Real weight = b == 1 ? 1500 * 10 * (3 - y) : 1500 * 10 * 2 + 2000 * 10 * (1 - y);
      EXPECT_NEAR(stress[6 * p + 1], -weight, 1e-6 * weight);
      EXPECT_NEAR(stress[6 * p], -(b == 1 ? 0.6 : 0.5) * weight, 1e-6 * weight);
      if (b == 0) {
        EXPECT_NEAR(stress[6 * p + 2], -0.5 * weight, 1e-6 * weight);
      }
    }
  }
  // A surcharge and a surface above add their weight; gravity may point anywhere along an axis.
  const Simulation loaded(read(k_layers, {"body.lower.initial_stress.surcharge=7e3"}));
  EXPECT_NEAR(loaded.solver().field(0, "stress").values[1] - sim.solver().field(0, "stress").values[1], -7e3, 1e-3);
  const Simulation buried(read(k_layers, {"body.lower.initial_stress.surface=3.5"}));
  EXPECT_NEAR(buried.solver().field(0, "stress").values[1] - sim.solver().field(0, "stress").values[1], -7.5e3, 1e-3);
}

TEST(InitialStress, ground_stays_at_rest) {
  for (const std::vector<std::string>& sets :
       {std::vector<std::string>{}, {"solver.stress_order=musl"}, {"solver.transfer=flip"}, {"solver.precision=single"}}) {
    Simulation sim(read(k_layers, sets));
    const std::vector<Real> start = sim.solver().field(0, "stress").values;
    sim.run();
    const std::vector<Real> end = sim.solver().field(0, "stress").values;
    Real moved = 0;
    for (std::size_t k = 0; k < start.size(); ++k) moved = std::max(moved, std::abs(end[k] - start[k]));
    // The layer of neo-Hookean solid is heavier by the volume that it would have without its stress.
    EXPECT_LT(moved, 5e-3 * 5e4) << fmt::format("{}", fmt::join(sets, " "));
    EXPECT_LT(sim.solver().totals(0).kinetic_energy, 1e-6 * 5e4 * 3);
  }
}

TEST(InitialStress, the_implicit_solver_starts_in_balance) {
  // Elements integrate a linear stress exactly; the law flows, so they may have one.
  const std::string text = R"(
gravity = [0, -10]
[grid]
upper = [1, 2]
cells = [2, 4]
[time]
end = 1
dt = 0.5
[solver]
type = "implicit"
mode = "static"
basis = "element"
[[body]]
name = "ground"
method = "elements"
region = { type = "box", lower = [0, 0], upper = [1, 2] }
initial_stress = { type = "geostatic", K0 = 0.5 }
material = { type = "j2", density = 2000, youngs_modulus = 1e7, poissons_ratio = 0.3, yield_stress = 1e5 }
[[boundary]]
side = "left"
kind = "slip"
[[boundary]]
side = "right"
kind = "slip"
[[boundary]]
side = "bottom"
kind = "slip"
)";
  Simulation sim(read(text));
  sim.run();
  Real moved = 0;
  for (const Real u : sim.solver().node_field(0, "displacement").values) moved = std::max(moved, std::abs(u));
  EXPECT_LT(moved, 1e-10);
  Simulation without(read(text, {"body.ground.initial_stress={ type = \"geostatic\", K0 = 0.5, surcharge = 1e3 }"}));
  without.run();
  Real sunk = 0;
  for (const Real u : without.solver().node_field(0, "displacement").values) sunk = std::max(sunk, std::abs(u));
  EXPECT_GT(sunk, 1e-5) << "a surcharge that nothing presses with";
}

TEST(InitialStress, particles_of_the_implicit_solver_are_brought_to_rest_and_what_is_not_at_rest_is_not) {
  for (const char* basis : {"bspline", "element"}) {
    const auto greatest_energy = [&](std::vector<std::string> sets) {
      sets.insert(sets.begin(), {"solver.type=implicit", fmt::format("solver.basis={}", basis), "time.dt=0.02", "time.end=0.2"});
      Simulation sim(read(k_layers, sets));
      Real greatest = 0;
      while (sim.time() < 0.2 - 1e-9) {
        sim.step();
        greatest = std::max(greatest, sim.solver().totals(0).kinetic_energy + sim.solver().totals(1).kinetic_energy);
      }
      return greatest / (5e4 * 3);
    };
    EXPECT_LT(greatest_energy({}), 1e-9) << basis;
    // The stress of the start is the weight above, but for some per cent of it in the rows at wall and surface.
    const Simulation sim(read(k_layers, {"solver.type=implicit", fmt::format("solver.basis={}", basis), "time.dt=0.02"}));
    const std::vector<Real> x = sim.solver().field(0, "position").values, stress = sim.solver().field(0, "stress").values;
    for (std::size_t p = 0; 2 * p < x.size(); ++p)
      EXPECT_NEAR(stress[6 * p + 1], -(1500 * 10 * 2 + 2000 * 10 * (1 - x[2 * p + 1])), 0.03 * 5e4) << basis;
    // A surcharge that nothing presses with lets it rise, and a stress that carries less lets it sink.
    EXPECT_GT(greatest_energy({"body.upper.initial_stress.surcharge=2e4"}), 1e-7) << basis;
    EXPECT_GT(greatest_energy({"body.upper.initial_stress={ type = \"uniform\", value = [-5e3, -1e4, -5e3, 0] }"}), 1e-7) << basis;
  }
}

TEST(InitialStress, a_table_gives_each_particle_the_stress_of_the_nearest_point) {
  const TemporaryFolder folder;
  // At the particles' places that of the layers, in no order, with a column more.
  const Simulation layers(read(k_layers));
  const std::vector<Real> x = layers.solver().field(0, "position").values, stress = layers.solver().field(0, "stress").values;
  std::vector<std::size_t> order(x.size() / 2);
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k * 7 % order.size();
  std::ofstream file(folder.path() / "stress.csv");
  file << "\xef\xbb\xbf"
       << "yy, \"xx\",x,y,point,zz,xy\r\n";
  std::string positions, stresses;
  for (const std::size_t p : order) {
    const Real* const s = stress.data() + 6 * p;
    file << fmt::format("{},{},{},{},{},{},{}\n", s[1], s[0], x[2 * p] + 0.01, x[2 * p + 1] - 0.01, p, s[2], s[3]);
    positions += fmt::format("[{}, {}], ", x[2 * p] + 0.01, x[2 * p + 1] - 0.01);
    stresses += fmt::format("[{}, {}, {}, {}], ", s[0], s[1], s[2], s[3]);
  }
  file.close();
  const std::string inline_table = fmt::format("{{ type = \"table\", positions = [{}], stresses = [{}] }}", positions, stresses);
  const std::string from_file = fmt::format("{{ type = \"table\", file = \"{}\" }}", (folder.path() / "stress.csv").string());
  for (const std::string& table : {inline_table, from_file}) {
    const Case problem = read(k_layers, {"body.lower.initial_stress=" + table});
    Simulation sim(problem);
    EXPECT_LT(greatest_difference(sim.solver().field(0, "stress").values, stress), 1e-10 * 5e4);
    // What the file said goes with the case.
    if (table == from_file) std::filesystem::remove(folder.path() / "stress.csv");
    Simulation again(Case::from_input(parse_toml(write_toml(problem.to_input()), "again.toml"), "case"));
    EXPECT_EQ(again.solver().field(0, "stress").values, sim.solver().field(0, "stress").values);
  }
}

TEST(InitialStress, the_nearest_point_is_found_in_3D_too) {
  const std::string text = R"(
dim = 3
[grid]
upper = [1, 1, 1]
cells = [3, 3, 3]
[time]
end = 0.1
[[body]]
name = "rock"
region = { type = "box", lower = [0, 0, 0], upper = [1, 1, 1] }
layout = { type = "per_cell", count = 8 }
material = { type = "j2", density = 2000, youngs_modulus = 1e9, poissons_ratio = 0.3, yield_stress = 1e6 }
)";
  std::vector<Vec3> points;
  std::string positions, stresses;
  for (int k = 0; k < 60; ++k) {
    points.push_back({std::fmod(0.37 * k, 1), std::fmod(0.61 * k, 1), std::fmod(0.83 * k, 1)});
    positions += fmt::format("[{}, {}, {}], ", points.back()[0], points.back()[1], points.back()[2]);
    stresses += fmt::format("[{}, 0, 0, 0, 0, 0], ", -10 * k);
  }
  const Simulation sim(
      read(text, {fmt::format("body.rock.initial_stress={{ type = \"table\", positions = [{}], stresses = [{}] }}", positions, stresses)}));
  const std::vector<Real> x = sim.solver().field(0, "position").values, stress = sim.solver().field(0, "stress").values;
  for (std::size_t p = 0; 3 * p < x.size(); ++p) {
    const auto distance = [&](const Vec3& point) {
      return std::hypot(point[0] - x[3 * p], point[1] - x[3 * p + 1], point[2] - x[3 * p + 2]);
    };
    const auto nearest =
        std::min_element(points.begin(), points.end(), [&](const Vec3& a, const Vec3& b) { return distance(a) < distance(b); });
    EXPECT_NEAR(stress[6 * p], -10.0 * static_cast<Real>(nearest - points.begin()), 1e-6);
  }
}

TEST(InitialStress, a_table_that_cannot_be_read_is_refused_with_the_place) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "stress.csv").string();
  const auto with = [&](const std::string& content) {
    std::ofstream(path) << content;
    return complaint({fmt::format("body.lower.initial_stress={{ type = \"table\", file = \"{}\" }}", path)});
  };
  EXPECT_NE(with("x,y,xx,yy,zz\n0,0,1,2,3\n").find("stress.csv:1: has no column \"xy\"; its first line must name x, y, xx, yy, zz, xy"),
            std::string::npos);
  EXPECT_NE(with("x,y,xx,yy,zz,xy\n0,0,1,2,3,4\n\n0,0,1,2,3\n").find("stress.csv:4: has 5 values; the first line names 6"),
            std::string::npos);
  EXPECT_NE(with("x,y,xx,yy,zz,xy\n0,0,1,2,3,four\n").find("stress.csv:2: xy = \"four\" is not a finite number"), std::string::npos);
  EXPECT_NE(with("x,y,xx,yy,zz,xy\n0,0,1,2,3,nan\n").find("is not a finite number"), std::string::npos);
  EXPECT_NE(with("x,y,xx,yy,zz,xy\n").find("has no rows"), std::string::npos);
  EXPECT_NE(with(std::string(65 << 20, '1')).find("has more than 64 MB; thin the table out"), std::string::npos);
  EXPECT_NE(with("").find("has no column \"x\""), std::string::npos);
  EXPECT_NE(complaint({"body.lower.initial_stress={ type = \"table\", file = \"no.csv\" }"}).find("cannot read \"no.csv\": No such file"),
            std::string::npos);
  EXPECT_NE(complaint({"body.lower.initial_stress={ type = \"table\", file = \"/\" }"}).find("\"/\" is no file"), std::string::npos);
  EXPECT_NE(complaint({"body.lower.initial_stress={ type = \"table\" }"}).find("has no points"), std::string::npos);
  EXPECT_NE(
      complaint({"body.lower.initial_stress={ type = \"table\", positions = [[0, 0]] }"}).find("positions has 1 entries and stresses 0"),
      std::string::npos);
  EXPECT_NE(complaint({"body.lower.initial_stress={ type = \"table\", positions = [[0, 0]], stresses = [[1, 2]] }"})
                .find("stresses: 2 numbers; give 4: xx yy zz xy"),
            std::string::npos);
}

TEST(InitialStress, what_cannot_be_is_refused_with_what_can) {
  EXPECT_NE(complaint({"gravity=[1, -10]"}).find("needs gravity along one axis"), std::string::npos);
  EXPECT_NE(complaint({"gravity=[0, 0]"}).find("needs gravity along one axis"), std::string::npos);
  EXPECT_NE(complaint({"body.upper.region.lower=[0, 1.5]"}).find("with a gap, need \"uniform\""), std::string::npos);
  EXPECT_NE(complaint({"body.upper.formulation=total"}).find("keeps its stress in F"), std::string::npos);
  EXPECT_NE(complaint({"body.lower.initial_stress.overconsolidation=2"}).find("overconsolidation is for cam_clay"), std::string::npos);
  EXPECT_NE(complaint({"body.lower.initial_stress.surface=1.5"}).find("surface = 1.5 is below the top"), std::string::npos);
  EXPECT_NE(complaint({"body.lower.initial_stress={ type = \"uniform\", value = [1, 2] }"}).find("value has 2 numbers; give 4"),
            std::string::npos);
  EXPECT_NE(complaint({"body.lower.initial_stress={ type = \"geostatc\", K0 = 1 }"}).find("did you mean \"geostatic\"?"),
            std::string::npos);
}

TEST(InitialStress, what_is_doubtful_is_said) {
  EXPECT_FALSE(has_warning({}, "initial stress"));
  EXPECT_TRUE(has_warning({"body.lower.initial_stress.K0=0.2"}, "beyond the yield surface of \"drucker_prager\""));
  // Nothing holds the sides: both fly off, and the body as a whole stays.
  EXPECT_TRUE(has_warning({"grid.lower=[-1, 0]", "grid.upper=[2, 4]", "grid.cells=[12, 16]"}, "starts out of balance"));
  EXPECT_TRUE(has_warning({"body.lower.initial_stress={ type = \"uniform\", value = [-1e3, -1e3, -1e3, 0] }"}, "starts out of balance"));
}

TEST(InitialStress, parameters_can_be_taken_by_name) {
  const Case problem = read(k_layers, {"body.upper.material=copper_ofhc", "body.upper.initial_stress.K0=1"});
  EXPECT_EQ(problem.bodies[1].material->type(), "johnson_cook");
  EXPECT_EQ(problem.bodies[1].material->density(), 8960);
  EXPECT_NE(complaint({"body.upper.material=coper_ofhc"}).find("did you mean \"copper_ofhc\"?"), std::string::npos);
}

}  // namespace
}  // namespace matpoint::test
