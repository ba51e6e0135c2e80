// `matpoint verify`: runs problems with known answers and compares. One job is one simulation (or a few) that yields measured numbers;
// a row compares one of them with a published or exact value.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/types.hpp"

namespace matpoint {

enum class Bound { within, at_most, at_least };
enum class RowKind { accept, truth, goal };

/// One line of the table.
struct VerifyRow {
  std::string group;  ///< "8.3", "axial_bar", ...
  std::string quantity;
  Real expected = 0;   ///< Published or exact value.
  Real tolerance = 0;  ///< Absolute, for Bound::within.
  Bound bound = Bound::within;
  RowKind kind = RowKind::accept;
  std::string source;
};

using Measured = std::map<std::string, Real>;

struct VerifyJob {
  std::string group;                    ///< The rows' group that its numbers belong to.
  std::string name;                     ///< "disks, 316 points, USL"
  std::string case_name;                ///< The shipped case, another name for the group.
  bool is_quick = false;                ///< In the quick preset.
  bool is_full = true;                  ///< In the full preset.
  double cost = 0;                      ///< About how many particle-steps; the dearest start first.
  std::vector<std::string> quantities;  ///< What run() measures; one that is missing afterwards is a failure.
  std::function<Measured()> run;
};

/// Jobs, and what their numbers are compared with.
struct VerifySuite {
  std::vector<VerifyJob> jobs;
  std::vector<VerifyRow> rows;
};

/// The seven examples of the thesis by Kamuth.
VerifySuite thesis_suite();

/// Problems with closed-form answers, and invariants.
VerifySuite analytic_suite();

/// Both.
VerifySuite verify_suite();

struct VerifyOptions {
  std::vector<std::string> names;  ///< Groups, cases or jobs to run; empty: all of the preset.
  std::string preset = "quick";    ///< "quick" (minutes, for every change) or "full" (hours).
  std::string csv = "verify.csv";
  std::vector<std::string> sets;  ///< KEY=VALUE of numerics for the everyday problems, in place of the defaults and qualities.
  int threads = 0;  ///< Jobs side by side; 0: one per processor.
};

/// Runs, prints the table, writes the csv. Returns 0, or 3 when an accepted bound is missed, a job fails or does not measure what it
/// says. Throws InputError for unknown names.
int run_verify(const VerifySuite& suite, const VerifyOptions& options);
int run_verify(const VerifyOptions& options);

/// The jobs of a preset, one line each, for `matpoint verify --list`.
std::vector<std::string> list_verify_jobs(const std::string& preset);

}  // namespace matpoint
