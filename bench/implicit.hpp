// The implicit solver's time by stage, and its linear solvers beside each other.
#pragma once

#include <string>

namespace matpoint::bench {

/// Prints the table, and writes it to `csv` unless empty. `threads`: 0 for 1 and 2 threads in turn.
void run_implicit(const std::string& csv, int threads);

/// The same of the disk on a plate of finite elements, row 2 of the published table: seconds of whole runs by stage, J = 2 and 3.
void run_coupled(const std::string& csv, int threads);

}  // namespace matpoint::bench
