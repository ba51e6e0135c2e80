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

namespace matpoint {
namespace {

bool is_in_preset(const VerifyJob& job, const std::string& preset) { return preset == "full" ? job.is_full : job.is_quick; }

std::vector<VerifyJob> all_jobs() {
  std::vector<VerifyJob> jobs = thesis_jobs();
  for (VerifyJob& job : analytic_jobs()) jobs.push_back(std::move(job));
  return jobs;
}

std::vector<VerifyRow> all_rows() {
  std::vector<VerifyRow> rows = thesis_rows();
  for (VerifyRow& row : analytic_rows()) rows.push_back(std::move(row));
  return rows;
}

std::vector<VerifyJob> choose_jobs(const VerifyOptions& options) {
  if (options.preset != "quick" && options.preset != "full") {
    throw InputError("preset \"{}\" is unknown, allowed: \"quick\" or \"full\"{}", options.preset, did_you_mean(options.preset, {"quick", "full"}));
  }
  std::vector<VerifyJob> jobs;
  std::set<std::string> known;
  for (VerifyJob& job : all_jobs()) {
    known.insert({job.group, job.case_name});
    const auto is_named = [&](const std::string& name) { return name == job.group || name == job.case_name; };
    if (!options.names.empty() && std::none_of(options.names.begin(), options.names.end(), is_named)) continue;
    if (is_in_preset(job, options.preset)) jobs.push_back(std::move(job));
  }
  for (const std::string& name : options.names) {
    if (known.count(name) == 0) {
      const std::vector<std::string> names(known.begin(), known.end());
      throw InputError("nothing to verify is called \"{}\"{}; known: {}", name, did_you_mean(name, names), list_names(names));
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
      } catch (const std::exception& error) {
        failure = fmt::format("{} {}: {}", job.group, job.name, error.what());
      }
      const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      const std::lock_guard lock(mutex);
      fmt::print(stderr, "{:10s} {} {} ({:.1f} s)\n", job.group, job.name, failure.empty() ? "done" : "FAILED", seconds);
      for (const auto& [quantity, value] : measured) measurements.values[{job.group, quantity}] = value;
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

std::string csv_text(const std::string& text) { return '"' + text + '"'; }

}  // namespace

std::vector<std::string> list_verify_jobs(const std::string& preset) {
  std::vector<std::string> lines;
  for (const VerifyJob& job : all_jobs()) {
    if (is_in_preset(job, preset)) lines.push_back(fmt::format("{:18s} {:16s} {}  (about {:.1e} particle-steps)", job.group, job.case_name, job.name, job.cost));
  }
  return lines;
}

int run_verify(const VerifyOptions& options) {
  const std::vector<VerifyJob> jobs = choose_jobs(options);
  std::ofstream csv(options.csv);
  if (!csv) throw InputError("cannot write \"{}\": {}", options.csv, std::strerror(errno));
  csv << "case,quantity,published,ours,bound,tolerance,kind,result,source\n";
  const Measurements measurements = run_jobs(jobs, options.threads);

  fmt::print("\n{:16s} {:36s} {:>16s} {:>16s} {:>12s}  {:8s} {}\n", "case", "quantity", "published", "ours", "bound", "", "source");
  int passed = 0;
  int failed = static_cast<int>(measurements.failures.size());
  std::set<std::pair<std::string, std::string>> reported;
  std::set<std::string> groups;
  for (const VerifyJob& job : jobs) groups.insert(job.group);
  for (const VerifyRow& row : all_rows()) {
    const auto measured = measurements.values.find({row.group, row.quantity});
    const bool is_measured = measured != measurements.values.end();
    if (groups.count(row.group) == 0 || (!is_measured && row.kind == RowKind::goal)) continue;
    if (!is_measured && row.kind == RowKind::accept) {
      if (options.preset == "quick") continue;  // measured by a job of the full preset
      ++failed;
      fmt::print("{:16s} {:36s} not measured\n", row.group, row.quantity);
      continue;
    }
    std::string result = "";
    if (row.kind == RowKind::accept) {
      const bool is_met = holds(row, measured->second);
      result = is_met ? "ok" : "MISSED";
      ++(is_met ? passed : failed);
    }
    const std::string ours = is_measured ? fmt::format("{:.10g}", measured->second) : "";
    const std::string bound = row.kind == RowKind::truth ? kind_text(row.kind)
                              : row.bound == Bound::within ? fmt::format("+- {:.3g}", row.tolerance)
                                                           : fmt::format("{} {:.3g}", bound_text(row.bound), row.expected);
    const std::string published = row.bound == Bound::within ? fmt::format("{:.10g}", row.expected) : "";
    fmt::print("{:16s} {:36s} {:>16s} {:>16s} {:>12s}  {:8s} {}\n", row.group, row.quantity, published, ours, bound, result, row.source);
    csv << fmt::format("{},{},{},{},{},{},{},{},{}\n", row.group, row.quantity, row.expected, is_measured ? fmt::format("{}", measured->second) : "",
                       bound_text(row.bound), row.tolerance, kind_text(row.kind), result, csv_text(row.source));
    reported.insert({row.group, row.quantity});
  }
  for (const auto& [key, value] : measurements.values) {
    if (reported.count(key) > 0) continue;
    fmt::print("{:16s} {:36s} {:>16s} {:>16.10g} {:>12s}\n", key.first, key.second, "", value, "");
    csv << fmt::format("{},{},,{},,,reported,,\n", key.first, key.second, value);
  }
  for (const std::string& failure : measurements.failures) fmt::print("FAILED: {}\n", failure);
  csv.flush();
  if (!csv) throw SolverError("cannot write \"{}\": {}", options.csv, std::strerror(errno));
  fmt::print("\nverify ({}): {} passed, {} failed; table in {}\n", options.preset, passed, failed, options.csv);
  return failed == 0 ? 0 : 3;
}

}  // namespace matpoint
