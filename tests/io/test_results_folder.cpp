#include <gmock/gmock.h>
#include <gtest/gtest.h>
#if __has_include(<hdf5.h>)
#include <hdf5.h>
#else
#include <hdf5/serial/hdf5.h>
#endif

#include <unistd.h>

#include <algorithm>

#include "case/case_file.hpp"
#include "core/version.hpp"
#include "io/fake_solver.hpp"
#include "io/results_folder.hpp"
#include "io/state_file.hpp"
#include "kernel/kernel.hpp"
#include "support/temporary_folder.hpp"

namespace matpoint {
namespace {

namespace fs = std::filesystem;
using test::FakeSolver;
using test::FileSizeLimit;
using test::message_of;
using test::read_text;
using test::TemporaryFolder;
using testing::ElementsAre;
using testing::HasSubstr;

/// A case with the two bodies of FakeSolver, as far as outputs look at it.
Case make_case() {
  Case problem = load_case("disks");
  problem.bodies.resize(2);
  problem.bodies[0].name = "left";
  problem.bodies[1].name = "right";
  problem.output = OutputSpec{};
  problem.probes.clear();
  return problem;
}

std::vector<std::string> files_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_directory() && entry.path().filename() != k_lock_name) names.push_back(fs::relative(entry.path(), folder).string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

Snapshot at(const Case& problem, const FakeSolver& solver, Index step) {
  Snapshot snapshot(problem, solver);
  snapshot.step = step;
  snapshot.time = 0.1 * static_cast<Real>(step);
  return snapshot;
}

class ResultsFolderTest : public testing::Test {
 protected:
  /// A short run with history at steps 0, 1, 2 and fields at 0, 2.
  void run(ExistingFolder existing = ExistingFolder::refuse) {
    ResultsFolder results(path, existing);
    results.begin(at(problem, solver, 0), 2, "matpoint run case.toml");
    for (const Index step : {0, 1, 2}) {
      results.write_history(at(problem, solver, step));
      if (step != 1) results.write_fields(at(problem, solver, step));
    }
    results.finish(at(problem, solver, 2), "finished");
  }
  std::string refusal(ExistingFolder existing = ExistingFolder::refuse) {
    return message_of<InputError>([&] { run(existing); });
  }

  TemporaryFolder folder;
  fs::path path = folder.path() / "results" / "case";
  Case problem = make_case();
  FakeSolver solver;
};

TEST_F(ResultsFolderTest, holds_what_the_case_asks_for_and_nothing_else) {
  problem.output.formats = {"vtkhdf", "vtu"};
  problem.output.grid = true;
  problem.probes.resize(1);
  problem.probes[0].name = "tip";
  problem.probes[0].body = "right";
  problem.probes[0].particle = 1;
  run();
  EXPECT_THAT(files_in(path), ElementsAre("grid.pvd", "grid.vtkhdf", "history.csv", "left.pvd", "left.vtkhdf", "manifest.toml",
                                          "probe_tip.csv", "right.pvd", "right.vtkhdf", "vtkhdf/grid_000000.h5", "vtkhdf/grid_000001.h5",
                                          "vtkhdf/left_000000.h5", "vtkhdf/left_000001.h5", "vtkhdf/right_000000.h5",
                                          "vtkhdf/right_000001.h5", "vtu/grid_000000.vti", "vtu/grid_000001.vti", "vtu/left_000000.vtu",
                                          "vtu/left_000001.vtu", "vtu/right_000000.vtu", "vtu/right_000001.vtu"));
}

TEST_F(ResultsFolderTest, only_the_wanted_fields_are_written) {
  problem.output.formats = {"vtu"};
  problem.output.fields = {"position", "velocity"};
  run();
  const std::string text = read_text(path / "vtu" / "left_000000.vtu");
  EXPECT_THAT(text, HasSubstr("Name=\"velocity\" NumberOfComponents=\"3\""));
  EXPECT_THAT(text, Not(HasSubstr("Name=\"stress\"")));
  EXPECT_FALSE(fs::exists(path / "left.vtkhdf"));
}

TEST_F(ResultsFolderTest, manifest_reads_back_with_case_version_and_end) {
  run();
  const std::string text = read_text(path / "manifest.toml");
  EXPECT_TRUE(text.starts_with("# matpoint results\n"));
  const Input manifest = parse_toml(text, "manifest.toml");
  EXPECT_EQ(manifest.find("status")->as_string(), "finished");
  EXPECT_EQ(manifest.find("command")->as_string(), "matpoint run case.toml");
  EXPECT_EQ(manifest.find("version")->as_string(), version());
  EXPECT_EQ(manifest.find("commit")->as_string(), commit());
  EXPECT_EQ(manifest.find("threads")->as_integer(), 2);
  EXPECT_EQ(manifest.find("steps")->as_integer(), 2);
  EXPECT_EQ(manifest.find("time")->as_real(), 0.2);
  EXPECT_EQ(manifest.find("instruction_set")->as_string(), instruction_set());
  EXPECT_EQ(manifest.find("started")->as_string().size(), std::string("2025-01-31T12:00:00Z").size());
  EXPECT_EQ(write_toml(Case::from_input(*manifest.find("case"), "disks").to_input()), write_toml(problem.to_input()));
  const Input& units = *manifest.find("units");
  EXPECT_EQ(units.find("history")->find("kinetic_energy")->as_string(), "J");
  EXPECT_EQ(units.find("history")->find("stress_xx")->as_string(), "Pa");
  EXPECT_EQ(units.find("fields")->find("stress")->as_string(), "Pa");
}

TEST_F(ResultsFolderTest, manifest_says_running_until_the_end_and_why_a_run_failed) {
  ResultsFolder results(path);
  results.begin(at(problem, solver, 0), 1);
  const auto status = [&] { return parse_toml(read_text(path / "manifest.toml"), "manifest.toml").find("status")->as_string(); };
  EXPECT_EQ(status(), "running");
  results.fail(at(problem, solver, 1), "step 2: state is not finite");
  EXPECT_EQ(status(), "failed");
  EXPECT_THAT(read_text(path / "manifest.toml"), HasSubstr("step 2: state is not finite"));
}

TEST_F(ResultsFolderTest, last_written_names_times_and_folder) {
  ResultsFolder results(path);
  EXPECT_EQ(results.last_written(), "nothing in " + path.string());
  results.begin(at(problem, solver, 0), 1);
  results.write_history(at(problem, solver, 4));
  EXPECT_EQ(results.last_written(), "history at t = 0.4 s, no fields in " + path.string());
  results.write_fields(at(problem, solver, 5));
  EXPECT_EQ(results.last_written(), "history at t = 0.4 s, fields at t = 0.5 s in " + path.string());
}

TEST_F(ResultsFolderTest, a_step_is_written_once) {
  ResultsFolder results(path);
  results.begin(at(problem, solver, 0), 1);
  results.write_history(at(problem, solver, 0));
  const std::string once = read_text(path / "history.csv");
  results.write_history(at(problem, solver, 0));
  EXPECT_EQ(read_text(path / "history.csv"), once);
}

TEST_F(ResultsFolderTest, earlier_results_are_refused_and_stay) {
  run();
  const std::string history = read_text(path / "history.csv");
  EXPECT_EQ(refusal(),
            "results folder \"" + path.string() +
                "\" exists and is not empty; give --overwrite (overwrite=True) to replace it, or another folder with --out (output=...)");
  EXPECT_EQ(read_text(path / "history.csv"), history);
}

TEST_F(ResultsFolderTest, empty_folder_may_be_used) {
  fs::create_directories(path);
  run();
  EXPECT_TRUE(fs::exists(path / "history.csv"));
}

TEST_F(ResultsFolderTest, overwrite_deletes_the_earlier_run_and_nothing_else) {
  problem.output.formats = {"vtu"};
  run();
  const std::vector<std::string> mine = {"notes.txt", "other.vtkhdf", "vtu/left_final.vtu", "vtu/other_000000.vtu"};
  for (const std::string& name : mine) std::ofstream(path / name) << "mine";
  std::ofstream(path / "vtu" / "left_000007.vtu.tmp") << "left over from a run that was killed";
  problem.output.formats = {"vtkhdf"};
  run(ExistingFolder::overwrite);
  EXPECT_THAT(files_in(path), ElementsAre("history.csv", "left.vtkhdf", "manifest.toml", "notes.txt", "other.vtkhdf", "right.vtkhdf",
                                          "vtkhdf/left_000000.h5", "vtkhdf/left_000001.h5", "vtkhdf/right_000000.h5",
                                          "vtkhdf/right_000001.h5", "vtu/left_final.vtu", "vtu/other_000000.vtu"));
  EXPECT_EQ(read_text(path / "notes.txt"), "mine");
}

TEST_F(ResultsFolderTest, overwrite_refuses_a_folder_of_someone_else) {
  fs::create_directories(path);
  std::ofstream(path / "thesis.tex") << "years of work";
  EXPECT_THAT(refusal(ExistingFolder::overwrite), HasSubstr("holds files but no manifest.toml, so no run of matpoint wrote it"));
  std::ofstream(path / "manifest.toml") << "files = [\"thesis.tex\"]\n";
  EXPECT_THAT(refusal(ExistingFolder::overwrite), HasSubstr("manifest.toml\" was not written by matpoint"));
  EXPECT_EQ(read_text(path / "thesis.tex"), "years of work");
}

TEST_F(ResultsFolderTest, overwrite_never_leaves_the_folder) {
  fs::create_directories(path);
  const fs::path outside = folder.path() / "results" / "precious.csv";
  std::ofstream(outside) << "data";
  std::ofstream(path / "manifest.toml") << "# matpoint results\nfiles = [\"../precious.csv\", \"" << outside.string() << "\"]\n";
  run(ExistingFolder::overwrite);
  EXPECT_EQ(read_text(outside), "data");
}

TEST_F(ResultsFolderTest, place_that_cannot_be_a_folder_is_an_input_error) {
  std::ofstream(folder.path() / "results") << "a file";
  EXPECT_THAT(refusal(), HasSubstr("cannot create results folder \"" + path.string() + "\": Not a directory"));
  path = folder.path() / "results";
  EXPECT_THAT(refusal(), HasSubstr("there is a file of that name"));
  path = "/proc/matpoint-results";
  EXPECT_THAT(refusal(), HasSubstr("cannot create results folder \"/proc/matpoint-results\": "));
}

TEST_F(ResultsFolderTest, disk_that_is_full_from_the_start_is_an_input_error) {
  const FileSizeLimit limit(100);
  EXPECT_THAT(refusal(), HasSubstr("cannot create results folder \"" + path.string() + "\": cannot write \"" + path.string() +
                                   "/manifest.toml\": File too large"));
}

TEST_F(ResultsFolderTest, disk_that_fills_up_is_a_solver_error_and_the_rest_stays) {
  ResultsFolder results(path);
  results.begin(at(problem, solver, 0), 1);
  results.write_history(at(problem, solver, 0));
  results.write_fields(at(problem, solver, 0));
  results.wait();
  const std::string history = read_text(path / "history.csv");
  const FileSizeLimit limit(history.size() + 10);
  EXPECT_EQ(message_of<SolverError>([&] { results.write_history(at(problem, solver, 1)); }),
            "cannot write \"" + (path / "history.csv").string() + "\": File too large");
  results.write_fields(at(problem, solver, 1));
  EXPECT_THAT(message_of<SolverError>([&] { results.wait(); }), HasSubstr("left_000001.h5\": File too large"));
  results.write_fields(at(problem, solver, 2));
  EXPECT_THAT(message_of<SolverError>([&] { results.finish(at(problem, solver, 2), "finished"); }), HasSubstr("File too large"))
      << "an error of the last fields must not be lost";
  results.fail(at(problem, solver, 1), "disk full");
  EXPECT_EQ(read_text(path / "history.csv"), history);
  EXPECT_EQ(results.last_written(), "history at t = 0 s, fields at t = 0 s in " + path.string());
}

TEST_F(ResultsFolderTest, names_that_cannot_be_files_are_input_errors) {
  problem.bodies[0].place = "case.toml:12";
  for (const char* name : {"a/b", "../up", "", "a,b", "a\nb", ".hidden"}) {
    problem.bodies[0].name = name;
    EXPECT_THAT(refusal(), HasSubstr("case.toml:12: body \"" + printable(name) + "\": its results cannot be named so"));
  }
  problem.bodies[0].name = "grid";
  problem.output.grid = true;
  EXPECT_THAT(refusal(), HasSubstr("body \"grid\": its files would have the names of the grid's"));
  EXPECT_FALSE(fs::exists(path));
}

TEST_F(ResultsFolderTest, probes_of_one_name_are_an_input_error) {
  problem.probes.resize(2);
  for (ProbeSpec& probe : problem.probes) {
    probe.name = "tip";
    probe.body = "left";
    probe.particle = 0;
  }
  EXPECT_THAT(refusal(), HasSubstr("probe \"tip\": another probe has this name"));
}

TEST_F(ResultsFolderTest, unknown_field_is_an_input_error_with_the_nearest_name) {
  problem.output.fields = {"velocty"};
  EXPECT_THAT(refusal(), HasSubstr("output: fields: \"velocty\" is unknown, allowed: \"position\", \"velocity\", "));
  EXPECT_THAT(refusal(), HasSubstr("did you mean \"velocity\"?"));
  EXPECT_FALSE(fs::exists(path));
}

TEST_F(ResultsFolderTest, positions_of_a_grid_in_map_coordinates_keep_their_digits) {
  const auto is_double = [&](Real away) {
    solver.geometry.lower = {away, 2, 0};
    run(fs::exists(path) ? ExistingFolder::overwrite : ExistingFolder::refuse);
    const hid_t file = H5Fopen((path / "vtkhdf" / "left_000000.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    const hid_t points = H5Dopen2(file, "Points", H5P_DEFAULT);
    const hid_t type = H5Dget_type(points);
    const std::size_t size = H5Tget_size(type);
    H5Tclose(type);
    H5Dclose(points);
    H5Fclose(file);
    return size == sizeof(double);
  };
  EXPECT_FALSE(is_double(-1));
  EXPECT_FALSE(is_double(100));
  EXPECT_TRUE(is_double(4.6e6));
}

TEST_F(ResultsFolderTest, a_folder_that_is_being_written_is_refused_to_others) {
  ResultsFolder first(path);
  first.begin(at(problem, solver, 0), 1);
  EXPECT_THAT(refusal(ExistingFolder::overwrite), HasSubstr("is in use: process "));
  EXPECT_TRUE(folder_use(path).is_locked);
  EXPECT_TRUE(folder_use(path).is_here());
  EXPECT_EQ(folder_use(path).process, ::getpid());
}

TEST_F(ResultsFolderTest, goes_on_from_a_checkpoint_as_if_nothing_had_been_written_after_it) {
  problem.output.formats = {"vtkhdf", "vtu"};
  problem.probes = {{"tip", "left", 1, {}, ""}};
  const auto write = [&](ResultsFolder& results, Index first, Index last) {
    for (Index step = first; step <= last; ++step) {
      results.write_history(at(problem, solver, step));
      results.write_fields(at(problem, solver, step));
    }
  };
  StateTable saved;
  {
    ResultsFolder results(path);
    results.begin(at(problem, solver, 0), 1);
    write(results, 0, 3);
    results.write_checkpoint(at(problem, solver, 3), {{"simulation/here", std::vector<Index>{3}}});
    write(results, 4, 6);
    results.write_checkpoint(at(problem, solver, 6), {});
    results.write_checkpoint(at(problem, solver, 7), {});
    results.wait();
    EXPECT_EQ(checkpoints_of(path).size(), 2u) << "the last two are kept";
    results.write_checkpoint(at(problem, solver, 3), {{"simulation/here", std::vector<Index>{3}}});
    write(results, 9, 9);
    results.wait();
  }
  const std::vector<std::string> names = {"history.csv", "probe_tip.csv", "left.vtkhdf", "left.pvd"};
  const auto texts = [&](const fs::path& folder) {
    std::vector<std::string> all;
    for (const std::string& name : names) all.push_back(read_text(folder / name));
    return all;
  };
  ResultsFolder again(path, ExistingFolder::overwrite);
  StateTable table;
  {
    ResultsFolder whole(folder.path() / "whole");
    whole.begin(at(problem, solver, 0), 1);
    write(whole, 0, 3);
    whole.write_checkpoint(at(problem, solver, 3), {{"simulation/here", std::vector<Index>{3}}});
    write(whole, 4, 5);
    whole.finish(at(problem, solver, 5), "finished");
    table = read_state(checkpoints_of(folder.path() / "whole").back());
  }
  EXPECT_EQ(std::get<std::vector<Index>>(table.at("simulation/here")), std::vector<Index>{3});
  again.begin_again(at(problem, solver, 3), table, 1);
  write(again, 4, 5);
  again.finish(at(problem, solver, 5), "finished");
  EXPECT_EQ(texts(path), texts(folder.path() / "whole"));
}

TEST_F(ResultsFolderTest, states_that_are_damaged_are_refused) {
  fs::create_directories(path);
  const fs::path state = path / "state.h5";
  write_state(state, {{"a/b", std::vector<double>(300, 0.5)}, {"c", std::vector<float>{1, 2}}, {"d", std::vector<Index>{}}, {"e", "text"}});
  const StateTable table = read_state(state);
  EXPECT_EQ(std::get<std::string>(table.at("e")), "text");
  EXPECT_EQ(std::get<std::vector<float>>(table.at("c")), (std::vector<float>{1, 2}));
  EXPECT_EQ(table.size(), 4u);
  const std::string whole = read_text(state);
  for (std::size_t k = 0; k < whole.size(); k += 7) {
    std::string damaged = whole;
    damaged[k] = static_cast<char>(damaged[k] ^ 0x15);
    std::ofstream(state, std::ios::binary) << damaged;
    EXPECT_THAT(message_of<InputError>([&] { read_state(state); }), HasSubstr(state.string())) << "byte " << k;
  }
  std::ofstream(state, std::ios::binary) << whole << '\0';
  EXPECT_THAT(message_of<InputError>([&] { read_state(state); }), HasSubstr("is damaged"));
  std::ofstream(state, std::ios::binary) << whole.substr(512);
  EXPECT_THAT(message_of<InputError>([&] { read_state(state); }), HasSubstr("is no state of matpoint"));
  const std::string other = "matpoint state, format 9";
  std::ofstream(state, std::ios::binary) << other << whole.substr(other.size());
  EXPECT_THAT(message_of<InputError>([&] { read_state(state); }), HasSubstr("and this program reads \"matpoint state, format 2\""));
  std::ofstream(state, std::ios::binary) << whole.substr(0, whole.size() / 2);
  EXPECT_THROW(read_state(state), InputError);
  EXPECT_THAT(message_of<InputError>([&] { read_state(path / "none.h5"); }), HasSubstr("there is no state"));
}

}  // namespace
}  // namespace matpoint
