#include <gtest/gtest.h>

#include <random>

#include "implicit/linear_solver.hpp"
#include "support/from_toml.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

/// A Laplacian on a square of n x n nodes, with a drift that makes it unsymmetric.
SparseMatrix laplacian(int n, Real drift) {
  std::vector<Eigen::Triplet<Real>> entries;
  const auto number = [&](int i, int j) { return j * n + i; };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      entries.emplace_back(number(i, j), number(i, j), 4.1);
      if (i > 0) entries.emplace_back(number(i, j), number(i - 1, j), -1 - drift);
      if (i + 1 < n) entries.emplace_back(number(i, j), number(i + 1, j), -1 + drift);
      if (j > 0) entries.emplace_back(number(i, j), number(i, j - 1), -1);
      if (j + 1 < n) entries.emplace_back(number(i, j), number(i, j + 1), -1);
    }
  }
  SparseMatrix K(n * n, n * n);
  K.setFromTriplets(entries.begin(), entries.end());
  return K;
}

Vector random_vector(int size) {
  std::mt19937 random(1);
  std::uniform_real_distribution<Real> uniform(-1, 1);
  Vector b(size);
  for (Real& value : b) value = uniform(random);
  return b;
}

TEST(LinearSolver, every_method_solves_a_symmetric_system_and_takes_new_entries_in_the_same_places) {
  const SparseMatrix K = laplacian(20, 0);
  const SparseMatrix twice = 2 * K;
  const Vector b = random_vector(400);
  for (const std::string& name : linear_solver_names()) {
    SCOPED_TRACE(name);
    const auto solver = make_linear_solver(name, 1e-12);
    solver->analyze(K);
    for (const SparseMatrix* matrix : {&K, &twice}) {
      Vector x = Vector::Zero(400);
      ASSERT_TRUE(solver->factorize(*matrix, Symmetry::symmetric));
      ASSERT_TRUE(solver->solve(b, x));
      EXPECT_LT((*matrix * x - b).norm(), 1e-10 * b.norm());
    }
  }
}

TEST(LinearSolver, general_methods_solve_an_unsymmetric_system) {
  const SparseMatrix K = laplacian(20, 0.4);
  const Vector b = random_vector(400);
  for (const std::string& name : linear_solver_names()) {
    if (name == "cg" || name == "ldlt" || name == "cholmod") continue;
    SCOPED_TRACE(name);
    const auto solver = make_linear_solver(name, 1e-12);
    solver->analyze(K);
    Vector x = Vector::Zero(400);
    ASSERT_TRUE(solver->factorize(K, Symmetry::general));
    ASSERT_TRUE(solver->solve(b, x));
    EXPECT_LT((K * x - b).norm(), 1e-10 * b.norm());
  }
}

TEST(LinearSolver, auto_falls_back_to_lu_where_a_symmetric_matrix_is_not_definite) {
  SparseMatrix K = laplacian(6, 0);
  for (int k = 0; k < 36; k += 2) K.coeffRef(k, k) = -4.1;
  const auto solver = make_linear_solver("auto", 1e-12);
  solver->analyze(K);
  Vector x = Vector::Zero(36);
  const Vector b = random_vector(36);
  ASSERT_TRUE(solver->factorize(K, Symmetry::symmetric));
  EXPECT_NE(solver->name(), "ldlt");
  ASSERT_TRUE(solver->solve(b, x));
  EXPECT_LT((K * x - b).norm(), 1e-10 * b.norm());
  const SparseMatrix definite = laplacian(6, 0);
  ASSERT_TRUE(solver->factorize(definite, Symmetry::symmetric));
  EXPECT_EQ(solver->name(), "ldlt");
}

TEST(LinearSolver, direct_methods_say_when_a_matrix_is_singular) {
  // Rows that sum to zero: the constant is in the kernel, and b has a part along it.
  SparseMatrix K = laplacian(8, 0);
  for (int k = 0; k < K.outerSize(); ++k) {
    Real sum = 0;
    for (SparseMatrix::InnerIterator it(K, k); it; ++it) {
      if (it.row() != k) sum += it.value();
    }
    K.coeffRef(k, k) = -sum;
  }
  const Vector b = Vector::Ones(64);
  for (const std::string& name : linear_solver_names()) {
    if (name == "cg" || name == "bicgstab" || name == "gmres") continue;
    SCOPED_TRACE(name);
    const auto solver = make_linear_solver(name, 1e-12);
    solver->analyze(K);
    Vector x = Vector::Zero(64);
    EXPECT_FALSE(solver->factorize(K, Symmetry::symmetric) && solver->solve(b, x));
  }
}

TEST(LinearSolver, a_factorisation_of_a_large_problem_in_3d_is_warned_of) {
  const std::string text = R"(
dim = 3
gravity = [0, 0, -1]
[grid]
upper = [1.25, 0.625, 0.625]
cells = [52, 26, 26]
[time]
end = 1
dt = 1
[solver]
type = "implicit"
mode = "static"
[[body]]
name = "block"
region = { type = "box", lower = [0, 0, 0], upper = [1.1, 0.55, 0.55] }
layout = { type = "per_cell", count = 8 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }
[[boundary]]
side = "left"
kind = "fixed"
)";
  const auto is_warned = [&](const std::string& method, const std::string& cells) {
    const Simulation sim(read(text, {"solver.linear_solver=" + method, "grid.cells=" + cells}));
    const std::vector<std::string> warnings = sim.warnings();
    return std::any_of(warnings.begin(), warnings.end(), [](const std::string& warning) {
      return warning.find("unknowns in 3D: a factorisation takes some ") != std::string::npos;
    });
  };
  EXPECT_TRUE(is_warned("ldlt", "[52,26,26]"));
  EXPECT_FALSE(is_warned("cg", "[52,26,26]"));
  EXPECT_FALSE(is_warned("ldlt", "[26,13,13]"));
}

TEST(LinearSolver, unknown_name_is_refused) {
  EXPECT_NE(complaint_of([] { make_linear_solver("pardiso", 1e-10); }).find("\"pardiso\" is unknown, allowed: \"auto\""),
            std::string::npos);
}

}  // namespace
}  // namespace matpoint::test
