#include "case/linear_solver_names.hpp"

#include <algorithm>

namespace matpoint {
namespace {

struct Package {
  std::string name;
  std::vector<std::string> methods;
  bool is_here;
};

const std::vector<Package>& packages() {
  static const std::vector<Package> all = {
#ifdef MATPOINT_HAS_SUITESPARSE
      {"SuiteSparse", {"umfpack", "cholmod"}, true},
#else
      {"SuiteSparse", {"umfpack", "cholmod"}, false},
#endif
#ifdef MATPOINT_HAS_PETSC
      {"PETSc", {"gamg", "mumps"}, true},
#else
      {"PETSc", {"gamg", "mumps"}, false},
#endif
  };
  return all;
}

const Package* package_of(const std::string& method) {
  for (const Package& package : packages()) {
    if (std::find(package.methods.begin(), package.methods.end(), method) != package.methods.end()) return &package;
  }
  return nullptr;
}

}  // namespace

const std::vector<std::string>& linear_solver_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all = {"auto"};
    for (const Package& package : packages()) {
      if (package.is_here) all.insert(all.end(), package.methods.begin(), package.methods.end());
    }
    all.insert(all.end(), {"ldlt", "sparse_lu", "cg", "bicgstab", "gmres"});
    return all;
  }();
  return names;
}

std::string missing_package(const std::string& linear_solver) {
  const Package* const package = package_of(linear_solver);
  return package == nullptr || package->is_here ? "" : package->name;
}

bool factorizes_large(const std::string& linear_solver) {
  if (linear_solver == "auto") return !missing_package("gamg").empty();
  const std::vector<std::string> iterative = {"cg", "bicgstab", "gmres", "gamg"};
  return std::find(iterative.begin(), iterative.end(), linear_solver) == iterative.end();
}

bool is_of_petsc(const std::string& linear_solver) {
  const Package* const package = package_of(linear_solver);
  return package != nullptr && package->name == "PETSc";
}

}  // namespace matpoint
