#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.hpp"
#include "io/output_file.hpp"
#include "support/temporary_folder.hpp"

namespace matpoint {
namespace {

using test::FileSizeLimit;
using test::message_of;
using test::read_text;
using test::TemporaryFolder;
using testing::HasSubstr;

TEST(OutputFile, growing_file_can_be_read_after_every_append) {
  const TemporaryFolder folder;
  GrowingFile file(folder.path() / "a.csv", "a,b\n");
  EXPECT_EQ(read_text(folder.path() / "a.csv"), "a,b\n");
  file.append("1,2\n");
  EXPECT_EQ(read_text(folder.path() / "a.csv"), "a,b\n1,2\n");
}

TEST(OutputFile, full_disk_is_a_solver_error_with_file_and_reason) {
  EXPECT_EQ(message_of<SolverError>([&] { write_file("/proc/none", "row\n"); }).substr(0, 28), "cannot write \"/proc/none.tmp");
  const TemporaryFolder folder;
  GrowingFile file(folder.path() / "a.csv", "a\n");
  const FileSizeLimit limit(3);
  EXPECT_EQ(message_of<SolverError>([&] { file.append("row\n"); }),
            "cannot write \"" + (folder.path() / "a.csv").string() + "\": File too large");
}

TEST(OutputFile, row_that_does_not_fit_is_taken_back_whole) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.csv";
  GrowingFile file(path, "1,2,3,4\n");
  {
    const FileSizeLimit limit(12);  // half of the next row
    EXPECT_THAT(message_of<SolverError>([&] { file.append("5,6,7,8\n"); }), HasSubstr("a.csv\": File too large"));
    EXPECT_EQ(read_text(path), "1,2,3,4\n");
  }
  file.append("5\n");
  EXPECT_EQ(read_text(path), "1,2,3,4\n5\n");
}

TEST(OutputFile, file_in_a_missing_folder_names_the_reason) {
  const TemporaryFolder folder;
  EXPECT_THAT(message_of<SolverError>([&] { GrowingFile file(folder.path() / "no" / "a.csv", "a\n"); }),
              HasSubstr("No such file or directory"));
}

TEST(OutputFile, write_file_keeps_the_old_file_when_the_new_one_does_not_fit) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "manifest.toml";
  write_file(path, "old");
  {
    const FileSizeLimit limit(10);
    EXPECT_THAT(message_of<SolverError>([&] { write_file(path, std::string(100, 'x')); }), HasSubstr("manifest.toml\": File too large"));
  }
  EXPECT_EQ(read_text(path), "old");
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "manifest.toml.tmp"));
  write_file(path, "new");
  EXPECT_EQ(read_text(path), "new");
}

TEST(OutputFile, growing_file_goes_on_after_its_first_bytes) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "rows";
  {
    GrowingFile file(path, "one\n");
    file.append("two\nthree\n");
  }
  {
    GrowingFile file(path, 4);
    file.append("2\n");
    EXPECT_EQ(file.size(), 6);
    file.sync();
    file.close();
  }
  EXPECT_EQ(read_text(path), "one\n2\n");
  EXPECT_THAT(message_of<InputError>([&] { GrowingFile file(path, 7); }), HasSubstr("has 6 bytes, and had 7 when the state was saved"));
  EXPECT_EQ(read_text(path), "one\n2\n");
}

}  // namespace
}  // namespace matpoint
