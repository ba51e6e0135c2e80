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
  GrowingFile file(folder.path() / "a.csv");
  file.append("a,b\n");
  EXPECT_EQ(read_text(folder.path() / "a.csv"), "a,b\n");
  file.append("1,2\n");
  EXPECT_EQ(read_text(folder.path() / "a.csv"), "a,b\n1,2\n");
}

TEST(OutputFile, full_disk_is_a_solver_error_with_file_and_reason) {
  GrowingFile file("/dev/full");
  EXPECT_EQ(message_of<SolverError>([&] { file.append("row\n"); }), "cannot write \"/dev/full\": No space left on device");
}

TEST(OutputFile, row_that_does_not_fit_is_taken_back_whole) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.csv";
  GrowingFile file(path);
  file.append("1,2,3,4\n");
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
  EXPECT_THAT(message_of<SolverError>([&] { GrowingFile file(folder.path() / "no" / "a.csv"); }), HasSubstr("No such file or directory"));
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

TEST(OutputFile, reserve_space_fails_with_the_file_as_it_was) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "fields";
  write_file(path, "0123456789");
  {
    const FileSizeLimit limit(1000);
    EXPECT_THAT(message_of<SolverError>([&] { reserve_space(path, 2000); }), HasSubstr("fields\": File too large"));
  }
  EXPECT_EQ(read_text(path), "0123456789");
  reserve_space(path, 2000);
  EXPECT_EQ(std::filesystem::file_size(path), 2010u);
}

}  // namespace
}  // namespace matpoint
