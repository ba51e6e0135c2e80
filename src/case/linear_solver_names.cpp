#include "case/linear_solver_names.hpp"

namespace matpoint {
namespace {

const std::vector<std::string> k_suitesparse_names = {"umfpack", "cholmod"};

}  // namespace

const std::vector<std::string>& linear_solver_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all = {"auto", "ldlt", "sparse_lu", "cg", "bicgstab", "gmres"};
#ifdef MATPOINT_HAS_SUITESPARSE
    all.insert(all.begin() + 1, k_suitesparse_names.begin(), k_suitesparse_names.end());
#endif
    return all;
  }();
  return names;
}

const std::vector<std::string>& missing_linear_solver_names() {
#ifdef MATPOINT_HAS_SUITESPARSE
  static const std::vector<std::string> none;
  return none;
#else
  return k_suitesparse_names;
#endif
}

}  // namespace matpoint
