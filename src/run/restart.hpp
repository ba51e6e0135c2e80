// Runs that go on from a saved state: in the same results folder, or as a run of their own with other loads.
#pragma once

#include <filesystem>

#include "run/simulation.hpp"

namespace matpoint {

/// The newest state of a results folder that can be read; nothing without any. `complaints`: why newer ones cannot.
struct FoundState {
  std::filesystem::path path;
  StateTable table;
};
std::optional<FoundState> newest_state(const std::filesystem::path& folder, std::vector<std::string>& complaints);

/// A state, or the newest one of a results folder. Throws InputError.
FoundState find_state(const std::filesystem::path& path);

/// Throws InputError, with the first difference, for a case that is not the one that a state is of; titles and outputs may differ.
void check_same_case(const FoundState& state, const Case& problem);

/// The case that a state is of, as plain values, and its name. Throws InputError for one that has functions.
struct SavedCase {
  Input input;
  std::string name;
};
SavedCase saved_case(const FoundState& state);

/// The case that a state is of, with changes as of --set. Where `is_new_run`, throws InputError for changes of what the state itself
/// depends on: of the grid, the bodies' shapes and laws, the scheme. Other runs may change their outputs only.
Case case_of(const FoundState& state, const std::vector<std::string>& sets, bool is_new_run);

}  // namespace matpoint
