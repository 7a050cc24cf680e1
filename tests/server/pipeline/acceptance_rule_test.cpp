#include "server/pipeline/acceptance_rule.h"

#include <gmock/gmock.h>

#include <limits>

namespace meshloop {
namespace {

using testing::HasSubstr;
using What = AcceptanceRule::What;

ProposalRecord record(double confidence, double change_m) {
  ProposalRecord record;
  record.id = 1;
  record.content.confidence = confidence;
  record.content.largest_change_m = change_m;
  return record;
}

TEST(AcceptanceRule, TakesAllOrNothing) {
  EXPECT_TRUE(why_left_out({What::none, 0, 100}, record(1, 0.01)));
  EXPECT_FALSE(why_left_out({What::all, 1, 0}, record(0.1, 5)));
}

TEST(AcceptanceRule, TakesWhatIsSureWithItsLimits) {
  const AcceptanceRule rule{What::sure, 0.9, 0.05};
  EXPECT_FALSE(why_left_out(rule, record(0.9, 0.05)));
  EXPECT_THAT(why_left_out(rule, record(0.899, 0.05)).value_or(""), HasSubstr("confidence is 0.899, below 0.900"));
  EXPECT_THAT(why_left_out(rule, record(1, 0.0501)).value_or(""), HasSubstr("50 mm, more than 50"));
  EXPECT_THAT(why_left_out(rule, record(1, 0)).value_or(""), HasSubstr("cannot be told"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(why_left_out(rule, record(nan, 0.01)));
  EXPECT_TRUE(why_left_out(rule, record(1, nan)));
}

TEST(AcceptanceRule, NeverTakesWhatSomebodyTookBack) {
  for (const What what : {What::all, What::sure}) {
    auto rejected = record(1, 0.01);
    rejected.state = ProposalState::rejected;
    rejected.author = "anna";
    rejected.reason = "a toy";
    EXPECT_EQ(why_left_out({what, 0.5, 1}, rejected), "rejected by anna: a toy");
    auto undone = record(1, 0.01);
    undone.revision = 4;
    undone.author = "bert";
    EXPECT_EQ(why_left_out({what, 0.5, 1}, undone), "undone by bert");
    auto accepted = undone;
    accepted.state = ProposalState::accepted;
    EXPECT_TRUE(why_left_out({what, 0.5, 1}, accepted));
  }
}

}  // namespace
}  // namespace meshloop
