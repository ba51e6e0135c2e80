// The published numbers and their bounds, from verification/*.csv, which the build puts into the program.
#pragma once

#include "verify/verify.hpp"

namespace matpoint {

/// Texts of verification/*.csv by stem.
const std::map<std::string, std::string>& acceptance_tables();

/// The rows of verification/explicit_acceptance.csv (the thesis at its own scheme and time step), of explicit_musl.csv (the same
/// examples with MUSL at larger steps, against our reference computation) and of explicit_remedies.csv (what B-splines and contact mend).
std::vector<VerifyRow> acceptance_rows();

/// The rows of one of the tables.
std::vector<VerifyRow> acceptance_rows(const std::string& table);

}  // namespace matpoint
