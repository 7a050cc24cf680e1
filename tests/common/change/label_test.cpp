#include "common/change/label.h"

#include <gtest/gtest.h>

#include <set>

#include "common/change/comparison.h"

namespace meshloop {
namespace {

// The numbers of the label images, which never change.
static_assert(static_cast<int>(Label::unmeasured) == 0 && static_cast<int>(Label::unmodelled) == 1 &&
              static_cast<int>(Label::closer) == 2 && static_cast<int>(Label::farther) == 3 &&
              static_cast<int>(Label::agrees) == 4 && static_cast<int>(Label::undecided) == 5);

TEST(Labels, TheTableStandsInTheOrderOfTheNumbers) {
  for (std::size_t i = 0; i < kLabels.size(); ++i) EXPECT_EQ(static_cast<std::size_t>(kLabels[i].label), i);
}

TEST(Labels, OnlyThreeLabelsAskForAChange) {
  EXPECT_EQ(kind_of(Label::closer), ChangeKind::insertion);
  EXPECT_EQ(kind_of(Label::unmodelled), ChangeKind::insertion);
  EXPECT_EQ(kind_of(Label::farther), ChangeKind::removal);
  for (const Label label : {Label::unmeasured, Label::agrees, Label::undecided}) EXPECT_FALSE(is_change(label));
}

TEST(Labels, NamesDifferAndVisibleColorsToo) {
  std::set<std::string_view> names;
  std::set<std::array<int, 3>> paper;
  std::set<std::array<int, 3>> safe;
  std::size_t visible = 0;
  for (const auto& label : kLabels) {
    names.insert(label.name);
    if (label.opacity == Opacity::transparent) continue;
    ++visible;
    paper.insert({label.paper_color.r, label.paper_color.g, label.paper_color.b});
    safe.insert({label.safe_color.r, label.safe_color.g, label.safe_color.b});
  }
  EXPECT_EQ(names.size(), kLabels.size());
  EXPECT_EQ(paper.size(), visible);
  EXPECT_EQ(safe.size(), visible);
}

TEST(Comparison, CountsThePixelsOfEachLabel) {
  Comparison comparison;
  comparison.labels = Image<Label>{4, 2, Label::agrees};
  comparison.labels(0, 0) = Label::closer;
  comparison.labels(3, 1) = Label::undecided;
  std::array<std::size_t, kLabels.size()> expected{};
  expected[static_cast<std::size_t>(Label::agrees)] = 6;
  expected[static_cast<std::size_t>(Label::closer)] = 1;
  expected[static_cast<std::size_t>(Label::undecided)] = 1;
  EXPECT_EQ(comparison.counts(), expected);
  EXPECT_EQ(Comparison{}.counts(), (std::array<std::size_t, kLabels.size()>{}));
}

}  // namespace
}  // namespace meshloop
