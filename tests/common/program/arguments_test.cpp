#include "common/program/arguments.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/program/json_output.h"
#include "common/program/program.h"

namespace meshloop {
namespace {

TEST(FrameList, ReadsNumbersAndRangesInOrderAndOnce) {
  const auto frames = parse_frame_list("5,0,2-4,3");
  ASSERT_TRUE(frames);
  EXPECT_THAT(*frames, testing::ElementsAre(0, 2, 3, 4, 5));
}

TEST(FrameList, RefusesWhatIsNoList) {
  for (const char* text : {"", "a", "1-", "-1", "4-2", "1,,2", "1,", ",1", ",", "1.5", "9999999", "1 2"}) {
    const auto frames = parse_frame_list(text);
    ASSERT_FALSE(frames) << text;
    EXPECT_EQ(frames.error().kind, ErrorKind::usage);
  }
}

TEST(Between, TakesTheBoundsAndRefusesAllElse) {
  const auto check = between(0.5, 2);
  for (const char* text : {"0.5", "1", "2"}) EXPECT_EQ(check(text), "") << text;
  for (const char* text : {"0.4", "2.1", "-1", "nan", "inf", "a", ""}) EXPECT_NE(check(text), "") << text;
}

TEST(Counter, TakesWholeNumbersFromZeroOn) {
  const auto check = counter();
  for (const char* text : {"0", "7", "9223372036854775807"}) EXPECT_EQ(check(text), "") << text;
  EXPECT_EQ(check("-1"), "-1 is not a whole number from 0 on");
  for (const char* text : {"1.5", "0x1", "1e3", "9223372036854775808", "a", ""}) EXPECT_NE(check(text), "") << text;
}

TEST(SplitKind, SplitsAtTheFirstColon) {
  EXPECT_EQ(split_kind("recording:/a:b").kind, "recording");
  EXPECT_EQ(split_kind("recording:/a:b").rest, "/a:b");
  EXPECT_EQ(split_kind("none").rest, "");
}

TEST(Spread, IsTheMiddleAndTheSlowest) {
  EXPECT_TRUE(spread_json({}).is_null());
  EXPECT_EQ(spread_json({5, 1, 3, 2, 4}), (nlohmann::json{{"median", 3.0}, {"p95", 5.0}}));
}

TEST(JsonOutput, ReplacesBytesThatAreNoUtf8) {
  EXPECT_EQ(json_line({{"name", "r\xe4um"}}), "{\"name\":\"r\xef\xbf\xbdum\"}");
  EXPECT_EQ(json_page({{"a", 1}}), "{\n  \"a\": 1\n}\n");
}

int run(std::vector<std::string> words, const Action& action) {
  CLI::App app{"", "test"};
  prepare(app);
  CLI::App* go = app.add_subcommand("go");
  std::string text;
  go->add_option("--text", text);
  go->add_option("file", text);
  std::vector<char*> arguments;
  for (auto& word : words) arguments.push_back(word.data());
  return run_program(app, static_cast<int>(arguments.size()), arguments.data(), action);
}

TEST(RunProgram, ExitCodesFollowTheKindOfError) {
  EXPECT_EQ(run({"test", "go"}, [] { return Status{}; }), 0);
  EXPECT_EQ(run({"test", "go"}, [] { return Status{fail("x")}; }), 1);
  EXPECT_EQ(run({"test", "go"}, [] { return Status{fail("x", ErrorKind::usage)}; }), 2);
  EXPECT_EQ(run({"test", "go"}, [] { return Status{fail("x", ErrorKind::hardware_missing)}; }), 3);
  EXPECT_EQ(run({"test", "go"}, []() -> Status { throw std::runtime_error("x"); }), 1);
}

TEST(RunProgram, RefusesEmptyValuesByTheOptionsName) {
  const Action nothing = [] { return Status{}; };
  EXPECT_EQ(run({"test", "go", "--text", "a", "b"}, nothing), 0);
  for (const std::vector<std::string>& words : {std::vector<std::string>{"test", "go", "--text", ""},
                                                {"test", "go", "--text="},
                                                {"test", "go", "--text=", "b"}}) {
    testing::internal::CaptureStderr();
    EXPECT_EQ(run(words, nothing), 2);
    EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::HasSubstr("--text is given an empty value"));
  }
  testing::internal::CaptureStderr();
  EXPECT_EQ(run({"test", "go", ""}, nothing), 2);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::HasSubstr("file is given an empty value"));
}

TEST(RunProgram, NamesASubcommandThatItDoesNotKnow) {
  testing::internal::CaptureStderr();
  EXPECT_EQ(run({"test", "went", "--text", "a"}, [] { return Status{}; }), 2);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "test: 'went' is no subcommand of test; there are go\n");
}

TEST(RunProgram, NamesAnOptionThatItDoesNotKnow) {
  testing::internal::CaptureStderr();
  EXPECT_EQ(run({"test", "--went"}, [] { return Status{}; }), 2);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "test: test has no option '--went' (try --help)\n");
}

TEST(RunProgram, AnErrorThatQuotesAFileCannotDriveTheTerminal) {
  const Action failing = [] { return Status{fail("line 1: '\033]0;x\a\n\xc3\xa4'")}; };
  testing::internal::CaptureStderr();
  EXPECT_EQ(run({"test", "go", "--text", "a"}, failing), 1);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "test: line 1: '?]0;x? \xc3\xa4'\n");
}

TEST(RunProgram, WrongUsageIsTwoAndHelpIsNoError) {
  const Action nothing = [] { return Status{}; };
  EXPECT_EQ(run({"test"}, nothing), 2);
  EXPECT_EQ(run({"test", "go", "--unknown"}, nothing), 2);
  EXPECT_EQ(run({"test", "--help"}, nothing), 0);
  EXPECT_EQ(run({"test", "--version"}, nothing), 0);
}

}  // namespace
}  // namespace meshloop
