// manifest.toml: what made a results folder, and how the run ended.
#pragma once

#include <ctime>
#include <filesystem>

#include "io/snapshot.hpp"

namespace matpoint {

/// As "2025-01-31T12:00:00Z".
std::string time_stamp(std::time_t time);
/// Now.
inline std::string time_stamp() { return time_stamp(std::time(nullptr)); }

struct Manifest {
  std::string status = "running";  ///< "running", "finished", "interrupted", "failed", ...
  std::string message;             ///< Why the run failed.
  std::string command;             ///< The command line.
  int threads = 1;
  std::string started;
  std::string ended;                ///< Empty while the run goes on.
  std::vector<std::string> probes;  ///< For each probe: name, body and particle.
  std::vector<std::string> files;   ///< The folder's files; `*` stands for the digits of a series.
  Input case_input;                 ///< The resolved case.
  Input history_units;              ///< Units of the columns of history.csv and the probes, bodies' columns under the name of the sum.
  Input field_units;
};

/// The text of the file, with the state of the run.
std::string manifest_text(const Manifest& manifest, const Snapshot& snapshot);

/// An existing manifest. Throws InputError if it is none of ours.
Input read_manifest(const std::filesystem::path& path);

/// The files that the run of an existing manifest wrote, relative to its folder. Throws InputError if it is none of ours.
std::vector<std::string> manifest_files(const std::filesystem::path& path);

}  // namespace matpoint
