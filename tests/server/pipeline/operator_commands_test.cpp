#include "server/pipeline/operator_commands.h"

#include <gmock/gmock.h>
#include <unistd.h>

namespace meshloop {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using What = OperatorCommand::What;

TEST(OperatorCommands, AreWordsAndIds) {
  const auto all = parse_command("accept all").value();
  EXPECT_EQ(all.what, What::accept);
  EXPECT_TRUE(all.decisions.accept_all);
  EXPECT_THAT(parse_command("  accept\t1,3 ").value().decisions.accept, ElementsAre(1, 3));
  EXPECT_THAT(parse_command("accept 1, 3 ,5 , 7").value().decisions.accept, ElementsAre(1, 3, 5, 7));
  EXPECT_THAT(parse_command("accept 2-4").value().decisions.accept, ElementsAre(2, 3, 4));
  const auto reject = parse_command("reject 2,5 too  noisy \xc3\xb6 ").value();
  EXPECT_EQ(reject.what, What::reject);
  EXPECT_THAT(reject.decisions.reject, ElementsAre(2, 5));
  EXPECT_EQ(reject.decisions.reason, "too  noisy \xc3\xb6");
  const auto spaced = parse_command("reject 2, 5 noise, and more").value();
  EXPECT_THAT(spaced.decisions.reject, ElementsAre(2, 5));
  EXPECT_EQ(spaced.decisions.reason, "noise, and more");
  EXPECT_EQ(parse_command("reject 2").value().decisions.reason, "");
  EXPECT_EQ(parse_command("undo").value().what, What::undo);
  EXPECT_EQ(parse_command("redo ").value().what, What::redo);
  EXPECT_EQ(parse_command("list").value().what, What::list);
}

TEST(OperatorCommands, ThatAreNoneAreRefused) {
  for (const char* line : {"accept", "accept 0", "accept -1", "accept 1,", "accept 1 3", "accept 1, x", "accept 1, 3 5",
                           "accept all 3", "reject", "reject all", "reject x", "reject 2 a\x1b[2Jb", "undo 3",
                           "list all", "Accept 1", "accept1", "", "quit", "accept 99999999999999999999"}) {
    EXPECT_FALSE(parse_command(line)) << line;
  }
  EXPECT_THAT(parse_command("accept 1, 3 5").error().message, HasSubstr("'1, 3 5'"));
  EXPECT_THAT(parse_command("accept 1, x").error().message, HasSubstr("'1,x'"));
  EXPECT_THAT(parse_command("help").error().message, HasSubstr("accept, reject, undo, redo and list"));
  EXPECT_FALSE(parse_command("reject 2 " + std::string(501, 'x')));
}

class CommandLinesTest : public testing::Test {
 protected:
  CommandLinesTest() {
    EXPECT_EQ(::pipe(ends_), 0);
    lines_ = CommandLines{ends_[0]};
  }
  ~CommandLinesTest() override {
    ::close(ends_[0]);
    if (!is_closed_) ::close(ends_[1]);
  }
  void type(const std::string& text) {
    ASSERT_EQ(::write(ends_[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  void close_end() {
    ::close(ends_[1]);
    is_closed_ = true;
  }

  int ends_[2];
  bool is_closed_ = false;
  CommandLines lines_{-1};
};

TEST_F(CommandLinesTest, ComeWholeWithoutWaiting) {
  EXPECT_TRUE(lines_.read().empty());
  type("acc");
  EXPECT_TRUE(lines_.read().empty()) << "the line is not over";
  type("ept 1\r\n\n  \nundo\nre");
  EXPECT_THAT(lines_.read(), ElementsAre("accept 1", "undo"));
  EXPECT_FALSE(lines_.ended());
}

TEST_F(CommandLinesTest, EndWithTheInput) {
  type("undo\nlist");
  close_end();
  EXPECT_THAT(lines_.read(), ElementsAre("undo", "list"));
  EXPECT_TRUE(lines_.ended());
  EXPECT_TRUE(lines_.read().empty());
}

TEST_F(CommandLinesTest, DoNotGrowWithoutEnd) {
  for (int i = 0; i < 10; ++i) {
    type(std::string(4000, 'x'));
    EXPECT_TRUE(lines_.read().empty());
  }
  type("\nundo\n");
  const auto lines = lines_.read();
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_LE(lines[0].size(), 2002u);
  EXPECT_FALSE(parse_command(lines[0]));
  EXPECT_EQ(lines[1], "undo");
}

TEST_F(CommandLinesTest, ThatAreTooLongAreRefusedAndNotCutToOthers) {
  std::string ids = "accept 1";
  while (ids.size() < 1998) ids += ",1";
  ASSERT_EQ(ids.size(), 1998u);
  for (const auto& line : {ids + ",345", ids + ",3\r,45", ids + ",34\r5", "undo" + std::string(3000, ' '),
                           std::string(3000, ' ') + "undo", std::string(3000, ' ')}) {
    type(line + "\n");
    const auto lines = lines_.read();
    ASSERT_EQ(lines.size(), 1u);
    const auto command = parse_command(lines[0]);
    ASSERT_FALSE(command) << lines[0].size();
    EXPECT_THAT(command.error().message, HasSubstr("at most 2000 bytes"));
  }
  type(ids + ",3\r\n");
  EXPECT_THAT(parse_command(lines_.read().at(0)).value().decisions.accept, ElementsAre(1, 3)) << "the longest one";
}

TEST(CommandLines, OfNothingAreNone) {
  CommandLines none{-1};
  EXPECT_TRUE(none.ended());
  EXPECT_TRUE(none.read().empty());
  CommandLines closed{987};
  EXPECT_TRUE(closed.read().empty());
  EXPECT_TRUE(closed.ended()) << "a descriptor that is not open";
}

}  // namespace
}  // namespace meshloop
