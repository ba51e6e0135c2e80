// Bodies that meet: problems of `matpoint verify` whose bounds stand in verification/explicit_remedies.csv.
#pragma once

#include "verify/verify.hpp"

namespace matpoint {

void add_contact_jobs(std::vector<VerifyJob>& jobs);

}  // namespace matpoint
