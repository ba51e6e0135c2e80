// history.csv: sums over the bodies against time.
#pragma once

#include "io/output_file.hpp"
#include "io/snapshot.hpp"

namespace matpoint {

/// All bodies together, with what has crossed the system's border.
struct SystemTotals {
  BodyTotals sum;  ///< With no particles left, centre, extent and J are nan.
  Ledger ledger;
  /// What the transfers between particles and grid have taken since the start [J]; positive is a loss, negative a gain:
  /// E_start - (kinetic + strain + gravitational) - Ledger::energy_spent().
  Real transfer_loss = 0;
};

SystemTotals system_totals(const Snapshot& snapshot);

struct HistoryColumn {
  std::string name;
  std::string unit;
};

/// Columns of history.csv: time, step, dt, the totals, and the same sums for each body as `<body>.<sum>`.
std::vector<HistoryColumn> history_columns(const Solver& solver);

/// One row of history.csv, in the order of history_columns().
std::vector<Real> history_row(const Snapshot& snapshot);

/// What is written at one time: a row of the history, and one of each probe.
struct HistoryRecord {
  Index step = 0;
  std::vector<Real> history;
  std::vector<std::vector<Real>> probes;

  Real time() const { return history.front(); }
};

/// Between the records before and after a step, at a time [s] within it: linear, so that outputs do not cut steps. Counts, the step and
/// numbers of the step itself are those of the later record; what is nan in either is nan.
HistoryRecord interpolated(const HistoryRecord& before, const HistoryRecord& after, Real time, const Solver& solver);

class History {
 public:
  /// Creates the file with its header line. Throws SolverError.
  History(const std::filesystem::path& path, const Solver& solver);
  /// Goes on with a file, after its first `size` bytes.
  History(const std::filesystem::path& path, Index size) : file_(path, size) {}
  /// Appends one row, numbers as short as they can be and still read back to the same bits. Throws SolverError.
  void write(const std::vector<Real>& row);
  GrowingFile& file() { return file_; }

 private:
  GrowingFile file_;
};

/// The names as the first line of a CSV file.
std::string header_line(const std::vector<HistoryColumn>& columns);

/// The numbers as a line of a CSV file.
std::string csv_row(const std::vector<Real>& values);

}  // namespace matpoint
