#include "common/base/file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <functional>
#include <iterator>

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

/// What the child says with its files limited to 1000 bytes, in place of a full disk. A child, since the limit stays.
int exit_code_of_limited(const std::function<bool()>& is_as_wanted) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1000, 1000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    ::_exit(is_as_wanted() ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(File, AWriteThatFailsLeavesWhatStoodThereAndNothingElse) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_text_file(folder / "a", "before"));
  EXPECT_EQ(exit_code_of_limited([&] {
              const std::string text(2000, 'x');
              return !write_text_file(folder / "a", text) && !write_text_file(folder / "b", text);
            }),
            0);
  EXPECT_EQ(read_text_file(folder / "a", 10).value(), "before");
  const std::filesystem::directory_iterator files{folder.path()};
  EXPECT_EQ(std::distance(begin(files), end(files)), 1);
}

TEST(File, WritesThroughALinkAndKeepsTheRightsOfAFile) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_text_file(folder / "a", "before"));
  ASSERT_EQ(::chmod((folder / "a").c_str(), 0640), 0);
  std::filesystem::create_symlink("a", folder / "link");
  ASSERT_TRUE(write_text_file(folder / "link", "after"));
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(read_text_file(folder / "a", 10).value(), "after");
  ASSERT_TRUE(write_text_file(folder / "a", "again"));
  struct stat about {};
  ASSERT_EQ(::stat((folder / "a").c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777, 0640u);
}

TEST(File, OtherNamesOfAFileSeeWhatWasWritten) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_text_file(folder / "a", "before"));
  std::filesystem::create_hard_link(folder / "a", folder / "b");
  ASSERT_TRUE(write_text_file(folder / "b", "after"));
  EXPECT_EQ(read_text_file(folder / "a", 10).value(), "after");
}

TEST(File, ANameThatLeavesNoRoomForATemporaryOneIsWrittenInPlace) {
  const TemporaryFolder folder;
  const auto file = folder / std::string(255, 'a');
  ASSERT_TRUE(write_text_file(file, "old"));
  ASSERT_TRUE(write_text_file(file, "new"));
  EXPECT_EQ(read_text_file(file, 10).value(), "new");
}

TEST(File, AProtectedFileStays) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write every file";
  const TemporaryFolder folder;
  ASSERT_TRUE(write_text_file(folder / "a", "before"));
  ASSERT_EQ(::chmod((folder / "a").c_str(), 0444), 0);
  EXPECT_FALSE(write_text_file(folder / "a", "after"));
  EXPECT_EQ(read_text_file(folder / "a", 10).value(), "before");
}

TEST(File, ReplacingThroughALinkKeepsTheLink) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_text_file(folder / "a", "before"));
  std::filesystem::create_symlink("a", folder / "link");
  const std::string text = "after";
  ASSERT_TRUE(replace_file(folder / "link", std::as_bytes(std::span{text})));
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(read_text_file(folder / "a", 10).value(), "after");
}

TEST(File, WritingIntoAMissingFolderIsAnError) {
  const TemporaryFolder folder;
  const auto status = write_text_file(folder.path() / "none" / "a", "x");
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message, HasSubstr("none/a"));
}

}  // namespace
}  // namespace meshloop
