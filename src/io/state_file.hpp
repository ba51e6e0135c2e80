// Files with the state of a run: everything that decides how it goes on (core/state.hpp). docs/states.md describes the format.
#pragma once

#include <filesystem>

#include "core/state.hpp"

namespace matpoint {

/// Writes or replaces a file. On the disk when it returns. Throws SolverError, and then the file is what it was.
void write_state(const std::filesystem::path& path, const StateTable& table);

/// Throws InputError for a file that is no state, of another version of the format, cut short or changed.
StateTable read_state(const std::filesystem::path& path);

}  // namespace matpoint
