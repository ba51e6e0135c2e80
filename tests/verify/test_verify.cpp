// `matpoint verify`: that bounds that are missed, jobs that fail and numbers that nobody measures are told, with jobs of our own instead of
// simulations.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "core/error.hpp"
#include "verify/verify.hpp"

namespace matpoint {
namespace {

VerifyRow row(const std::string& quantity, Real expected, Real tolerance, Bound bound = Bound::within, RowKind kind = RowKind::accept) {
  return {"group", quantity, expected, tolerance, bound, kind, "Author (1994), \"title\""};
}

VerifyJob job(const std::string& name, std::vector<std::string> quantities, std::function<Measured()> run) {
  VerifyJob made;
  made.group = "group";
  made.case_name = "disks";
  made.name = name;
  made.is_quick = true;
  made.quantities = std::move(quantities);
  made.run = std::move(run);
  return made;
}

class Verify : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    options_.csv = (std::filesystem::temp_directory_path() / (std::string("matpoint_verify_") + test->name() + ".csv")).string();
    options_.threads = 2;
  }
  void TearDown() override { std::filesystem::remove(options_.csv); }

  /// Runs and captures what is printed.
  int run(const VerifySuite& suite) {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const int code = run_verify(suite, options_);
    printed_ = testing::internal::GetCapturedStdout();
    testing::internal::GetCapturedStderr();
    return code;
  }
  std::vector<std::string> csv() const {
    std::ifstream file(options_.csv);
    std::vector<std::string> lines;
    for (std::string line; std::getline(file, line);) lines.push_back(line);
    return lines;
  }
  /// The csv's line of a quantity, without its source.
  std::string csv_line(const std::string& quantity) const {
    for (const std::string& line : csv()) {
      if (line.find("," + quantity + ",") != std::string::npos) return line.substr(0, line.find(",\""));
    }
    return "no line";
  }

  VerifyOptions options_;
  std::string printed_;
};

TEST_F(Verify, test_bounds_that_hold_give_code_0_and_ok) {
  VerifySuite suite;
  suite.rows = {row("inside", 1, 0.1), row("below", 2, 0, Bound::at_most), row("above", 2, 0, Bound::at_least)};
  suite.jobs = {job("first", {"inside"},
                    [] {
                      return Measured{{"inside", 1.05}};
                    }),
                job("second", {"below", "above"}, [] {
                  return Measured{{"below", 1.5}, {"above", 2.5}};
                })};
  EXPECT_EQ(run(suite), 0);
  EXPECT_EQ(csv().at(0), "case,quantity,published,ours,bound,tolerance,kind,result,source");
  EXPECT_EQ(csv().at(1), "group,inside,1,1.05,+-,0.1,accept,ok,\"Author (1994), \"\"title\"\"\"");
  EXPECT_EQ(csv_line("below"), "group,below,2,1.5,<=,0,accept,ok");
  EXPECT_EQ(csv_line("above"), "group,above,2,2.5,>=,0,accept,ok");
  EXPECT_NE(printed_.find("verify (quick): 3 passed, 0 failed"), std::string::npos) << printed_;
}

TEST_F(Verify, test_number_beyond_its_bound_gives_code_3_and_missed) {
  const std::vector<std::pair<VerifyRow, Real>> misses = {{row("q", 1, 0.1), 1.11},
                                                          {row("q", 1, 0.1), 0.89},
                                                          {row("q", 2, 0, Bound::at_most), 2.1},
                                                          {row("q", 2, 0, Bound::at_least), 1.9},
                                                          {row("q", 1, 0.1), std::nan("")},
                                                          {row("q", 2, 0, Bound::at_most), std::nan("")},
                                                          {row("q", 1, 0.1), INFINITY}};
  for (const auto& [missed, value] : misses) {
    VerifySuite suite;
    suite.rows = {missed, row("good", 1, 0.1)};
    suite.jobs = {job("job", {"q", "good"}, [value = value] { return Measured{{"q", value}, {"good", 1}}; })};
    EXPECT_EQ(run(suite), 3) << value;
    EXPECT_NE(csv_line("q").find(",accept,MISSED"), std::string::npos) << csv_line("q");
    EXPECT_NE(csv_line("good").find(",accept,ok"), std::string::npos) << csv_line("good");
    EXPECT_NE(printed_.find("1 passed, 1 failed"), std::string::npos) << printed_;
  }
}

TEST_F(Verify, test_truth_and_goal_rows_never_fail) {
  VerifySuite suite;
  suite.rows = {row("truth", 1, 0, Bound::within, RowKind::truth), row("goal", 1, 0.1, Bound::within, RowKind::goal),
                row("later", 1, 0.1, Bound::within, RowKind::goal)};
  suite.jobs = {job("job", {"truth", "goal"}, [] { return Measured{{"truth", 7}, {"goal", 7}}; })};
  EXPECT_EQ(run(suite), 0);
  EXPECT_EQ(csv_line("truth"), "group,truth,1,7,+-,0,truth,");
  EXPECT_EQ(csv_line("goal"), "group,goal,1,7,+-,0.1,goal,");
  EXPECT_EQ(csv_line("later"), "no line");
}

TEST_F(Verify, test_job_that_throws_is_reported_and_fails) {
  VerifySuite suite;
  suite.rows = {row("q", 1, 0.1), row("good", 1, 0.1)};
  suite.jobs = {job("blows up", {"q"}, []() -> Measured { throw SolverError("det F = {}", -1); }), job("goes on", {"good"}, [] {
                  return Measured{{"good", 1}};
                })};
  EXPECT_EQ(run(suite), 3);
  EXPECT_NE(printed_.find("FAILED: group blows up: det F = -1"), std::string::npos) << printed_;
  EXPECT_EQ(csv_line("q"), "group,q,1,,+-,0.1,accept,NOT MEASURED");
  EXPECT_NE(csv_line("good").find(",accept,ok"), std::string::npos);
}

TEST_F(Verify, test_job_that_does_not_measure_what_it_says_fails) {
  VerifySuite suite;
  suite.rows = {row("q", 1, 0.1)};
  suite.jobs = {job("forgetful", {"q"}, [] { return Measured{}; })};
  EXPECT_EQ(run(suite), 3);
  EXPECT_NE(printed_.find("forgetful: did not measure q"), std::string::npos) << printed_;
}

TEST_F(Verify, test_row_of_no_job_fails_in_full_and_is_left_out_in_quick) {
  VerifySuite suite;
  suite.rows = {row("q", 1, 0.1), row("other", 1, 0.1)};
  suite.jobs = {job("job", {"q"}, [] { return Measured{{"q", 1}}; })};
  EXPECT_EQ(run(suite), 0);
  EXPECT_EQ(csv_line("other"), "no line");
  options_.preset = "full";
  EXPECT_EQ(run(suite), 3);
  EXPECT_EQ(csv_line("other"), "group,other,1,,+-,0.1,accept,NOT MEASURED");
}

TEST_F(Verify, test_number_without_a_row_is_reported) {
  VerifySuite suite;
  suite.jobs = {job("job", {}, [] { return Measured{{"extra", 0.1}}; })};
  EXPECT_EQ(run(suite), 0);
  EXPECT_EQ(csv_line("extra"), "group,extra,,0.1,,,reported,,");
}

TEST_F(Verify, test_only_named_jobs_of_the_preset_run) {
  VerifySuite suite;
  int ran = 0;
  suite.jobs = {job("a", {},
                    [&] {
                      ran += 1;
                      return Measured{};
                    }),
                job("b", {},
                    [&] {
                      ran += 10;
                      return Measured{};
                    }),
                job("c", {}, [&] {
                  ran += 100;
                  return Measured{};
                })};
  suite.jobs[1].group = "other";
  suite.jobs[1].case_name = "dam";
  suite.jobs[2].is_quick = false;
  options_.threads = 1;
  options_.names = {"disks"};
  run(suite);
  EXPECT_EQ(ran, 1);
  options_.names = {"other"};
  run(suite);
  EXPECT_EQ(ran, 11);
  options_.names = {"disks"};
  options_.preset = "full";
  run(suite);
  EXPECT_EQ(ran, 112);
}

TEST_F(Verify, test_a_job_may_be_named_and_answers_for_its_own_rows_only) {
  VerifySuite suite;
  suite.rows = {row("q", 1, 0.1), row("other", 1, 0.1)};
  suite.jobs = {job("first", {"q"}, [] { return Measured{{"q", 1}}; }), job("second", {"other"}, [] { return Measured{{"other", 1}}; })};
  options_.preset = "full";
  options_.names = {"first"};
  EXPECT_EQ(run(suite), 0);
  EXPECT_NE(csv_line("q").find(",accept,ok"), std::string::npos);
  EXPECT_EQ(csv_line("other"), "no line");
  suite.jobs[0].quantities.push_back("other");
  EXPECT_EQ(run(suite), 3);
}

/// The message of the InputError that run_verify throws.
std::string input_error(const VerifySuite& suite, const VerifyOptions& options) {
  try {
    run_verify(suite, options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST_F(Verify, test_unknown_name_is_refused_with_the_nearest) {
  VerifySuite suite;
  suite.jobs = {job("job", {}, [] { return Measured{}; })};
  options_.names = {"disk"};
  const std::string message = input_error(suite, options_);
  EXPECT_NE(message.find("nothing to verify is called \"disk\""), std::string::npos) << message;
  EXPECT_NE(message.find("did you mean \"disks\"?"), std::string::npos) << message;
  EXPECT_NE(message.find("group"), std::string::npos) << message;
}

TEST_F(Verify, test_unknown_preset_is_refused_with_the_nearest) {
  options_.preset = "ful";
  const std::string message = input_error(VerifySuite{}, options_);
  EXPECT_NE(message.find("preset \"ful\" is unknown"), std::string::npos) << message;
  EXPECT_NE(message.find("did you mean \"full\"?"), std::string::npos) << message;
}

TEST_F(Verify, test_csv_that_cannot_be_written_is_an_input_error_before_any_job_runs) {
  VerifySuite suite;
  bool has_run = false;
  suite.jobs = {job("job", {}, [&] {
    has_run = true;
    return Measured{};
  })};
  options_.csv = "/nowhere/verify.csv";
  EXPECT_NE(input_error(suite, options_).find("cannot write \"/nowhere/verify.csv\""), std::string::npos);
  EXPECT_FALSE(has_run);
}

// --- the suite that is shipped -----------------------------------------------------------------------------------------

using Key = std::pair<std::string, std::string>;

std::set<Key> measured_by(const VerifySuite& suite, bool VerifyJob::*preset) {
  std::set<Key> keys;
  for (const VerifyJob& each : suite.jobs) {
    if (!(each.*preset)) continue;
    for (const std::string& quantity : each.quantities) keys.insert({each.group, quantity});
  }
  return keys;
}

TEST(VerifySuite, test_every_accepted_row_belongs_to_a_job_of_the_full_preset) {
  const VerifySuite suite = verify_suite();
  const std::set<Key> measured = measured_by(suite, &VerifyJob::is_full);
  for (const VerifyRow& each : suite.rows) {
    if (each.kind != RowKind::accept) continue;
    EXPECT_EQ(measured.count({each.group, each.quantity}), 1u) << each.group << " " << each.quantity;
  }
}

TEST(VerifySuite, test_rows_and_jobs_stand_once) {
  const VerifySuite suite = verify_suite();
  std::set<Key> rows;
  for (const VerifyRow& each : suite.rows)
    EXPECT_TRUE(rows.insert({each.group, each.quantity}).second) << each.group << " " << each.quantity;
  std::set<Key> jobs;
  for (const VerifyJob& each : suite.jobs) EXPECT_TRUE(jobs.insert({each.group, each.name}).second) << each.group << " " << each.name;
}

TEST(VerifySuite, test_every_job_asserts_something_and_is_in_a_preset) {
  const VerifySuite suite = verify_suite();
  std::set<Key> accepted;
  for (const VerifyRow& each : suite.rows) {
    if (each.kind == RowKind::accept) accepted.insert({each.group, each.quantity});
  }
  for (const VerifyJob& each : suite.jobs) {
    EXPECT_TRUE(each.is_quick || each.is_full) << each.group << " " << each.name;
    EXPECT_TRUE(std::any_of(each.quantities.begin(), each.quantities.end(),
                            [&](const std::string& q) {
                              return accepted.count({each.group, q}) > 0;
                            }))
        << each.group << " " << each.name;
  }
}

TEST(VerifySuite, test_each_group_has_a_quick_job) {
  const VerifySuite suite = verify_suite();
  std::set<std::string> all;
  std::set<std::string> quick;
  for (const VerifyJob& each : suite.jobs) {
    all.insert(each.group);
    if (each.is_quick) quick.insert(each.group);
  }
  EXPECT_EQ(quick, all);
}

TEST(VerifySuite, test_bounds_are_no_blank_cheques) {
  for (const VerifyRow& each : verify_suite().rows) {
    EXPECT_FALSE(each.source.empty()) << each.group << " " << each.quantity;
    if (each.kind != RowKind::accept || each.bound != Bound::within) continue;
    EXPECT_GT(each.tolerance, 0) << each.group << " " << each.quantity;
    const Real scale = each.expected == 0 ? 1 : std::abs(each.expected);
    EXPECT_LT(each.tolerance, 0.2 * scale) << each.group << " " << each.quantity;
  }
}

}  // namespace
}  // namespace matpoint
