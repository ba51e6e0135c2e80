// The methods of PETSc, in programs that are built with it: they find what factorisations find, multigrid at a cost that hardly grows, and
// wrong options are named. The small systems of test_linear_solver.cpp go through them, too.
#include <gmock/gmock.h>

#include <thread>

#include "support/from_toml.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

/// A block that is clamped at one end and hangs, with a surface that cuts cells; of so many cells across the grid.
std::string hanging_block(int dim, int cells, const std::string& solver, const std::string& more = "") {
  const bool is_3d = dim == 3;
  return fmt::format(R"(
dim = {}
gravity = {}
[grid]
upper = {}
cell_size = {}
[time]
end = 1
dt = 1
[output]
fields = ["displacement"]
[solver]
type = "implicit"
mode = "static"
{}
[[body]]
name = "block"
region = {{ type = "box", lower = {}, upper = {} }}
layout = {{ type = "per_cell", count = {} }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }}
[[boundary]]
side = "left"
kind = "fixed"
attached = true
{}
)",
                     dim, is_3d ? "[0, 0, -5]" : "[0, -5]", is_3d ? "[1.2, 0.6, 0.6]" : "[1.2, 0.6]", 0.6 / cells, solver,
                     is_3d ? "[0, 0.11, 0.11]" : "[0, 0.11]", is_3d ? "[1.03, 0.49, 0.49]" : "[1.03, 0.49]", is_3d ? 8 : 9, more);
}

std::vector<Real> displacements(Simulation& sim) { return sim.solver().field(0, "displacement").values; }
Real number_of(const Simulation& sim, const std::string& name) {
  for (const StepNumber& number : sim.solver().step_numbers()) {
    if (number.name == name) return number.value;
  }
  return -1;
}
Real greatest_difference(const std::vector<Real>& a, const std::vector<Real>& b) {
  Real difference = 0, scale = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    difference = std::max(difference, std::abs(a[k] - b[k]));
    scale = std::max(scale, std::abs(a[k]));
  }
  return difference / scale;
}

TEST(PetscSolver, finds_what_a_factorisation_finds) {
  for (const int dim : {2, 3}) {
    for (const std::string basis : {"", "basis = \"element\"\nelement_order = 1\n", "surface_penalty = 10\n"}) {
      Simulation direct(read(hanging_block(dim, dim == 2 ? 6 : 4, basis + "linear_solver = \"umfpack\"")));
      direct.run();
      for (const std::string name : {"gamg", "mumps"}) {
        SCOPED_TRACE(fmt::format("{}D {} {}", dim, basis, name));
        Simulation ours(read(hanging_block(dim, dim == 2 ? 6 : 4, fmt::format("{}linear_solver = \"{}\"", basis, name))));
        ours.run();
        EXPECT_EQ(number_of(ours, "newton_iterations"), number_of(direct, "newton_iterations"));
        EXPECT_LT(greatest_difference(displacements(direct), displacements(ours)), 1e-8);
        EXPECT_EQ(number_of(ours, "linear_iterations") > 0, name == "gamg");
      }
    }
  }
}

TEST(PetscSolver, multigrid_needs_hardly_more_iterations_on_finer_grids) {
  std::vector<Real> per_solve;
  for (const int cells : {4, 8}) {
    Simulation sim(read(hanging_block(3, cells, "linear_solver = \"gamg\"")));
    sim.run();
    per_solve.push_back(number_of(sim, "linear_iterations") / number_of(sim, "newton_iterations"));
  }
  EXPECT_LT(per_solve[0], 40);
  EXPECT_LT(per_solve[1], 2 * per_solve[0]);
}

TEST(PetscSolver, multigrid_knows_the_rigid_motions_and_functions_in_thin_cuts) {
  const auto per_solve = [](int cells, const std::string& solver, const std::vector<std::string>& sets) {
    Simulation sim(read(hanging_block(2, cells, "linear_solver = \"gamg\"\n" + solver), sets));
    sim.run();
    return number_of(sim, "linear_iterations") / number_of(sim, "newton_iterations");
  };
  // 15.5; with constants in the place of the motions 23.
  EXPECT_LT(per_solve(60, "", {"gravity=[0,-1]"}), 19);
  // 20; with unknowns as they are 25, without motions 38.
  const std::vector<std::string> cut = {"gravity=[0,-1]", "body.block.region.lower=[0,0.105]", "body.block.region.upper=[1.03,0.493]"};
  EXPECT_LT(per_solve(30, "basis = \"element\"", cut), 23);
}

TEST(PetscSolver, takes_another_smoother_where_incomplete_cholesky_needs_a_shift) {
  const std::vector<std::string> sets = {"body.block.region.lower=[0,0.063,0.049]", "body.block.region.upper=[1.03,0.565,0.488]",
                                         "body.block.material.poissons_ratio=0.45", "gravity=[0,0,-1]"};
  std::vector<Real> found[2];
  for (const std::string name : {"umfpack", "gamg"}) {
    Simulation sim(read(hanging_block(3, 5, fmt::format("linear_solver = \"{}\"", name)), sets));
    sim.run();
    found[name == "gamg" ? 1 : 0] = displacements(sim);
    if (name == "gamg") EXPECT_GT(number_of(sim, "linear_iterations"), 50 * number_of(sim, "newton_iterations"));
  }
  EXPECT_LT(greatest_difference(found[0], found[1]), 1e-8);
}

TEST(PetscSolver, solves_unsymmetric_systems) {
  // A pressure that follows the surface.
  const std::string load = "[[load]]\nbody = \"block\"\nkind = \"pressure\"\npressure = 2e4\n";
  for (const int dim : {2, 3}) {
    std::vector<Real> found[2];
    for (const std::string name : {"umfpack", "gamg"}) {
      Simulation sim(read(hanging_block(dim, 5, fmt::format("linear_solver = \"{}\"", name), load)));
      sim.run();
      found[name == "gamg" ? 1 : 0] = displacements(sim);
    }
    EXPECT_LT(greatest_difference(found[0], found[1]), 1e-8) << dim;
  }
}

TEST(PetscSolver, takes_options_and_names_those_that_nothing_uses) {
  const auto run = [](const std::string& options) -> std::string {
    try {
      Simulation sim(read(hanging_block(2, 6, fmt::format("linear_solver = \"gamg\"\npetsc = \"{}\"", options))));
      sim.run();
      return fmt::format("{} iterations", number_of(sim, "linear_iterations"));
    } catch (const std::exception& error) {
      return error.what();
    }
  };
  EXPECT_THAT(run("-ksp_max_it 1"), testing::HasSubstr("gamg found no solution"));
  EXPECT_THAT(run("-ksp_tpye cg"), testing::HasSubstr("solver.petsc: nothing uses -ksp_tpye here"));
  EXPECT_NE(run("-mg_levels_ksp_max_it 4"), run(""));
  // Another preconditioner altogether: ours for multigrid are not in its way.
  EXPECT_THAT(run("-pc_type jacobi"), testing::HasSubstr("iterations"));
  EXPECT_THAT(run("-pc_type nonsense"), testing::HasSubstr("PETSc: "));
}

TEST(PetscSolver, works_for_simulations_side_by_side) {
  const std::string text = hanging_block(2, 6, "linear_solver = \"gamg\"");
  std::vector<std::vector<Real>> found(4);
  std::vector<std::thread> threads;
  for (std::vector<Real>& one : found) {
    threads.emplace_back([&text, &one] {
      Simulation sim(read(text, {"time.dt=0.1"}));
      sim.run();
      one = displacements(sim);
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<Real>& one : found) EXPECT_EQ(one, found[0]);
}

TEST(PetscSolver, a_run_that_goes_on_has_the_same_bits) {
  const std::string text = hanging_block(2, 6, "linear_solver = \"gamg\"");
  const std::vector<std::string> sets = {"time.dt=0.25"};
  Simulation whole(read(text, sets));
  whole.step();
  whole.step();
  Simulation second(read(text, sets));
  second.load_state(whole.save_state());
  for (Simulation* sim : {&whole, &second}) sim->run();
  EXPECT_EQ(difference_of(whole.save_state(), second.save_state()), "");
}

}  // namespace
}  // namespace matpoint::test
