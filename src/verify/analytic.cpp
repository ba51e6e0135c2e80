#include "verify/verify.hpp"
namespace matpoint {
std::vector<VerifyJob> analytic_jobs() { return {}; }
std::vector<VerifyRow> analytic_rows() { return {}; }
}
