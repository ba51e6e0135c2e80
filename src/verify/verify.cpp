#include "verify/verify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <mutex>
#include <optional>
#include <set>
#include <thread>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "verify/analytic.hpp"

namespace matpoint {
namespace {

bool is_in_preset(const VerifyJob& job, const std::string& preset) { return preset == "full" ? job.is_full : job.is_quick; }

std::vector<VerifyJob> choose_jobs(const VerifySuite& suite, const VerifyOptions& options) {
  if (options.preset != "quick" && options.preset != "full") {
    throw InputError("preset \"{}\" is unknown, allowed: \"quick\" or \"full\"{}", options.preset,
                     did_you_mean(options.preset, {"quick", "full"}));
  }
  std::vector<VerifyJob> jobs;
  std::set<std::string> known;
  for (const VerifyJob& job : suite.jobs) {
    known.insert({job.group, job.case_name, job.name});
    const auto is_named = [&](const std::string& name) { return name == job.group || name == job.case_name || name == job.name; };
    if (!options.names.empty() && std::none_of(options.names.begin(), options.names.end(), is_named)) continue;
    if (is_in_preset(job, options.preset)) jobs.push_back(job);
  }
  for (const std::string& name : options.names) {
    if (known.count(name) == 0) {
      const std::vector<std::string> names(known.begin(), known.end());
      std::set<std::string> groups;
      for (const VerifyJob& job : suite.jobs) groups.insert({job.group, job.case_name});
      throw InputError("nothing to verify is called \"{}\"{}; known: {}, and the jobs of --list", name, did_you_mean(name, names),
                       list_names({groups.begin(), groups.end()}));
    }
  }
  std::stable_sort(jobs.begin(), jobs.end(), [](const VerifyJob& a, const VerifyJob& b) { return a.cost > b.cost; });
  return jobs;
}

/// All numbers that were measured, by group and quantity; a job that failed leaves its message.
struct Measurements {
  std::map<std::pair<std::string, std::string>, Real> values;
  std::vector<std::string> failures;
};

Measurements run_jobs(const std::vector<VerifyJob>& jobs, int threads) {
  // Whole jobs side by side use the cores better than threads inside these small problems.
  const int workers = std::max(1, std::min<int>(threads > 0 ? threads : thread_count(), static_cast<int>(jobs.size())));
  const int threads_before = thread_count();
  set_thread_count(1);
  Measurements measurements;
  std::mutex mutex;
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t k = next++; k < jobs.size(); k = next++) {
      const VerifyJob& job = jobs[k];
      const auto start = std::chrono::steady_clock::now();
      Measured measured;
      std::string failure;
      try {
        measured = job.run();
        for (const std::string& quantity : job.quantities) {
          if (measured.count(quantity) == 0) throw SolverError("did not measure {}", quantity);
        }
      } catch (const std::exception& error) {
        failure = fmt::format("{} {}: {}", job.group, job.name, error.what());
      }
      const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      const std::lock_guard lock(mutex);
      fmt::print(stderr, "{:10s} {} {} ({:.1f} s)\n", job.group, job.name, failure.empty() ? "done" : "FAILED", seconds);
      for (const auto& [quantity, value] : measured) {
        measurements.values[{job.group, quantity}] = value;
        // The numbers of a long job at once: the table comes when all are done, and may be hours away.
        if (seconds > 60) fmt::print(stderr, "  {} = {:.10g}\n", quantity, value);
      }
      if (!failure.empty()) measurements.failures.push_back(failure);
    }
  };
  std::vector<std::thread> pool;
  for (int w = 1; w < workers; ++w) pool.emplace_back(work);
  work();
  for (std::thread& thread : pool) thread.join();
  set_thread_count(threads_before);
  return measurements;
}

const char* bound_text(Bound bound) { return bound == Bound::within ? "+-" : bound == Bound::at_most ? "<=" : ">="; }
const char* kind_text(RowKind kind) { return kind == RowKind::accept ? "accept" : kind == RowKind::truth ? "truth" : "goal"; }

bool holds(const VerifyRow& row, Real value) {
  switch (row.bound) {
    case Bound::within: return std::abs(value - row.expected) <= row.tolerance;
    case Bound::at_most: return value <= row.expected;
    case Bound::at_least: return value >= row.expected;
  }
  return false;
}

/// Text in quotes, those inside doubled.
std::string csv_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

/// The table on the screen and in the csv, and how it went.
class Table {
 public:
  explicit Table(const std::string& path) : path_(path), csv_(path) {
    if (!csv_) fail<InputError>();
    csv_ << "case,quantity,published,ours,bound,tolerance,kind,result,source\n";
  }
  void header() const {
    fmt::print("\n{:16s} {:36s} {:>16s} {:>16s} {:>12s}  {:12s} {}\n", "case", "quantity", "published", "ours", "bound", "", "source");
  }
  /// A row with its number, if there is one.
  void add(const VerifyRow& row, std::optional<Real> value) {
    std::string result;
    if (row.kind == RowKind::accept) {
      result = !value ? "NOT MEASURED" : holds(row, *value) ? "ok" : "MISSED";
      ++(result == "ok" ? passed : failed);
    }
    const std::string bound = row.kind == RowKind::truth   ? kind_text(row.kind)
                              : row.bound == Bound::within ? fmt::format("+- {:.3g}", row.tolerance)
                                                           : fmt::format("{} {:.3g}", bound_text(row.bound), row.expected);
    const std::string published = row.bound == Bound::within ? fmt::format("{:.10g}", row.expected) : "";
    fmt::print("{:16s} {:36s} {:>16s} {:>16s} {:>12s}  {:12s} {}\n", row.group, row.quantity, published,
               value ? fmt::format("{:.10g}", *value) : "", bound, result, row.source);
    csv_ << fmt::format("{},{},{},{},{},{},{},{},{}\n", row.group, row.quantity, row.expected, value ? fmt::format("{}", *value) : "",
                        bound_text(row.bound), row.tolerance, kind_text(row.kind), result, csv_text(row.source));
  }
  /// A number without a row.
  void add(const std::string& group, const std::string& quantity, Real value) {
    fmt::print("{:16s} {:36s} {:>16s} {:>16.10g} {:>12s}\n", group, quantity, "", value, "");
    csv_ << fmt::format("{},{},,{},,,reported,,\n", group, quantity, value);
  }
  void close() {
    csv_.flush();
    if (!csv_) fail<SolverError>();
  }

  int passed = 0;
  int failed = 0;

 private:
  template <class Error>
  [[noreturn]] void fail() const {
    throw Error("cannot write \"{}\": {}", path_, std::strerror(errno));
  }
  std::string path_;
  std::ofstream csv_;
};

/// Whether a row without a number is a failure: in the full preset always; in the quick one, and where jobs were asked for by their own
/// names, which measure only some rows of a group, when a job that ran says that it measures it.
bool must_be_measured(const VerifyRow& row, const std::vector<VerifyJob>& jobs, const VerifyOptions& options) {
  if (row.kind != RowKind::accept) return false;
  const bool is_whole = options.names.empty() || std::any_of(jobs.begin(), jobs.end(), [&](const VerifyJob& job) {
                          const auto has = [&](const std::string& name) {
                            return std::find(options.names.begin(), options.names.end(), name) != options.names.end();
                          };
                          return job.group == row.group && (has(job.group) || has(job.case_name));
                        });
  return (options.preset == "full" && is_whole) || std::any_of(jobs.begin(), jobs.end(), [&](const VerifyJob& job) {
           return job.group == row.group && std::count(job.quantities.begin(), job.quantities.end(), row.quantity) > 0;
         });
}

}  // namespace

VerifySuite verify_suite() {
  VerifySuite suite = thesis_suite();
  VerifySuite analytic = analytic_suite();
  std::move(analytic.jobs.begin(), analytic.jobs.end(), std::back_inserter(suite.jobs));
  std::move(analytic.rows.begin(), analytic.rows.end(), std::back_inserter(suite.rows));
  return suite;
}

std::vector<std::string> list_verify_jobs(const std::string& preset) {
  std::vector<std::string> lines;
  for (const VerifyJob& job : verify_suite().jobs) {
    if (is_in_preset(job, preset))
      lines.push_back(fmt::format("{:18s} {:16s} {}  (about {:.1e} particle-steps)", job.group, job.case_name, job.name, job.cost));
  }
  return lines;
}

int run_verify(const VerifySuite& suite, const VerifyOptions& options) {
  const std::vector<VerifyJob> jobs = choose_jobs(suite, options);
  Table table(options.csv);
  const Measurements measurements = run_jobs(jobs, options.threads);
  table.failed = static_cast<int>(measurements.failures.size());
  table.header();
  std::set<std::pair<std::string, std::string>> reported;
  std::set<std::string> groups;
  for (const VerifyJob& job : jobs) groups.insert(job.group);
  for (const VerifyRow& row : suite.rows) {
    if (groups.count(row.group) == 0) continue;
    const auto measured = measurements.values.find({row.group, row.quantity});
    const bool is_measured = measured != measurements.values.end();
    if (!is_measured && row.kind != RowKind::truth && !must_be_measured(row, jobs, options)) continue;
    table.add(row, is_measured ? std::optional(measured->second) : std::nullopt);
    reported.insert({row.group, row.quantity});
  }
  for (const auto& [key, value] : measurements.values) {
    if (reported.count(key) == 0) table.add(key.first, key.second, value);
  }
  for (const std::string& failure : measurements.failures) fmt::print("FAILED: {}\n", failure);
  table.close();
  fmt::print("\nverify ({}): {} passed, {} failed; table in {}\n", options.preset, table.passed, table.failed, options.csv);
  return table.failed == 0 ? 0 : 3;
}

int run_verify(const VerifyOptions& options) {
  if (options.sets.empty()) return run_verify(verify_suite(), options);
  VerifySuite suite;
  add_everyday(suite, options.sets);
  return run_verify(suite, options);
}

}  // namespace matpoint
