// probe_<name>.csv: one particle's motion and stress against time.
#pragma once

#include "io/history.hpp"

namespace matpoint {

/// The body and the id of a probe's particle; "nearest" is resolved with the positions of now, to the lower id when two are as near.
/// Throws InputError: unknown body, no such particle.
struct ProbeTarget {
  std::size_t body = 0;
  Index particle = 0;
  void declare_state(State& state) {
    state.add("body", body);
    state.add("particle", particle);
  }
};
ProbeTarget find_probe(const ProbeSpec& spec, const Solver& solver);

/// Columns of a probe's file: time, position, velocity, Cauchy stress.
std::vector<HistoryColumn> probe_columns(int dim);

class Probe {
 public:
  /// Creates the file with its header line. Throws SolverError.
  Probe(const std::filesystem::path& path, const ProbeTarget& target, int dim);
  /// Goes on with a file, after its first `size` bytes.
  Probe(const std::filesystem::path& path, const ProbeTarget& target, Index size) : target_(target), file_(path, size) {}
  /// Its row now; nan once the particle has been removed.
  std::vector<Real> row(const Snapshot& snapshot) const;
  /// Appends one row. Throws SolverError.
  void write(const std::vector<Real>& row);
  GrowingFile& file() { return file_; }

 private:
  ProbeTarget target_;
  GrowingFile file_;
};

}  // namespace matpoint
