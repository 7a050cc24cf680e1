#include "common/base/file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "temporary_folder.h"

namespace meshloop {
namespace {

using testing::HasSubstr;

TEST(File, GivesBackEveryByteThatWasWritten) {
  const TemporaryFolder folder;
  std::vector<std::byte> bytes;
  for (int i = 0; i < 70'000; ++i) bytes.push_back(static_cast<std::byte>(i * 31));
  ASSERT_TRUE(write_file(folder / "a", bytes));
  EXPECT_EQ(read_file(folder / "a", bytes.size()).value(), bytes);
}

TEST(File, AShorterContentReplacesALongerOne) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_text_file(folder / "a", "long text"));
  ASSERT_TRUE(write_text_file(folder / "a", "x"));
  EXPECT_EQ(read_text_file(folder / "a", 10).value(), "x");
}

TEST(File, AppendingMakesTheFileAndKeepsWhatIsThere) {
  const TemporaryFolder folder;
  ASSERT_TRUE(append_text_file(folder / "a", "1\n"));
  ASSERT_TRUE(append_text_file(folder / "a", "2\n"));
  EXPECT_EQ(read_text_file(folder / "a", 10).value(), "1\n2\n");
}

TEST(File, ReadsAnEmptyFile) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_file(folder / "a", {}));
  EXPECT_TRUE(read_file(folder / "a", 0).value().empty());
}

TEST(File, RefusesWhatIsMissingTooLargeOrNoFile) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_text_file(folder / "a", "12345"));
  EXPECT_THAT(read_file(folder / "a", 4).error().message, HasSubstr("too large (5 bytes; at most 4)"));
  EXPECT_THAT(read_file(folder / "none", 4).error().message, HasSubstr("No such file"));
  EXPECT_THAT(read_file(folder.path(), 4).error().message, HasSubstr("is not a file"));
  EXPECT_THAT(read_file("/dev/zero", 4).error().message, HasSubstr("is not a file"));
}

TEST(File, DoesNotWaitForAPipe) {
  const TemporaryFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THAT(read_file(folder / "pipe", 4).error().message, HasSubstr("is not a file"));
}

TEST(File, AFullDiskIsAnError) {
  EXPECT_THAT(write_text_file("/dev/full", "x").error().message, HasSubstr("No space left"));
  EXPECT_THAT(append_text_file("/dev/full", "x").error().message, HasSubstr("No space left"));
}

TEST(File, WritingIntoAMissingFolderIsAnError) {
  const TemporaryFolder folder;
  const auto status = write_text_file(folder.path() / "none" / "a", "x");
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message, HasSubstr("none/a"));
}

}  // namespace
}  // namespace meshloop
