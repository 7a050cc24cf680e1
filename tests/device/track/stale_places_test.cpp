#include "device/track/stale_places.h"

#include <gtest/gtest.h>

#include <limits>

namespace meshloop {
namespace {

const Eigen::Vector3d kHere{0.5, 0.2, 0.1};
const Eigen::Vector3d kThere{-0.5, 0.2, 0.1};

std::vector<Verdict> verdicts(const Eigen::Vector3d& place, int agreeing, int contradicting) {
  std::vector<Verdict> all(static_cast<std::size_t>(agreeing), {place, true});
  all.insert(all.end(), static_cast<std::size_t>(contradicting), {place, false});
  return all;
}

void judge(StalePlaces& places, int frames, const std::vector<Verdict>& each) {
  for (int i = 0; i < frames; ++i) places.judge(each);
}

TEST(StalePlaces, NothingIsStaleBeforeItWasSeenForSeveralFrames) {
  StalePlaces places;
  EXPECT_FALSE(places.contains(kHere));
  judge(places, 3, verdicts(kHere, 0, 5));
  EXPECT_FALSE(places.contains(kHere));
  judge(places, 1, verdicts(kHere, 0, 5));
  EXPECT_TRUE(places.contains(kHere));
}

TEST(StalePlaces, ContradictionsStayWhereTheyAre) {
  StalePlaces places;
  auto both = verdicts(kHere, 0, 3);
  both.push_back({kThere, true});
  judge(places, 10, both);
  EXPECT_TRUE(places.contains(kHere));
  EXPECT_FALSE(places.contains(kThere));
}

TEST(StalePlaces, AFewMistakesAmongWhatAgreesAreNoChange) {
  StalePlaces places;
  judge(places, 50, verdicts(kHere, 3, 2));
  EXPECT_FALSE(places.contains(kHere));
}

TEST(StalePlaces, WhatWasRightForLongTakesFramesToBecomeStaleAndBack) {
  StalePlaces places;
  judge(places, 100, verdicts(kHere, 4, 0));
  judge(places, 2, verdicts(kHere, 0, 4));
  EXPECT_FALSE(places.contains(kHere));
  judge(places, 4, verdicts(kHere, 0, 4));
  EXPECT_TRUE(places.contains(kHere));
  judge(places, 2, verdicts(kHere, 4, 0));
  EXPECT_TRUE(places.contains(kHere)) << "between the two limits nothing changes";
  judge(places, 6, verdicts(kHere, 4, 0));
  EXPECT_FALSE(places.contains(kHere));
}

TEST(StalePlaces, OneFrameWithManyVerdictsIsOneFrame) {
  StalePlaces places;
  places.judge(verdicts(kHere, 0, 10'000));
  EXPECT_FALSE(places.contains(kHere));
}

TEST(StalePlaces, PlacesFarBeyondAnyRoomAreTold) {
  constexpr double kFar = std::numeric_limits<double>::max();
  StalePlaces places;
  judge(places, 10, verdicts({kFar, -kFar, 0}, 0, 1));
  EXPECT_TRUE(places.contains({kFar, -kFar, 0}));
  EXPECT_FALSE(places.contains({0, 0, 0}));
}

TEST(StalePlaces, AreForgotten) {
  StalePlaces places;
  judge(places, 10, verdicts(kHere, 0, 1));
  places.clear();
  EXPECT_FALSE(places.contains(kHere));
}

}  // namespace
}  // namespace meshloop
