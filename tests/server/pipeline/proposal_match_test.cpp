#include "server/pipeline/proposal_match.h"

#include <gtest/gtest.h>

namespace meshloop {
namespace {

Eigen::AlignedBox3d box(const Eigen::Vector3d& low, const Eigen::Vector3d& size) {
  return {low, Eigen::Vector3d{low + size}};
}

/// 30 x 20 x 20 cm.
Eigen::AlignedBox3d crate(double x, double y = 0) {
  return box({x, y, 0}, {0.3, 0.2, 0.2});
}

ProposalContent content(const Eigen::AlignedBox3d& where, ProposalKind kind = ProposalKind::insertion) {
  ProposalContent content;
  content.kind = kind;
  content.box_m = where;
  return content;
}

ProposalRecord record(ProposalId id, const Eigen::AlignedBox3d& where, ProposalState state = ProposalState::open) {
  ProposalRecord record;
  record.id = id;
  record.content = content(where);
  record.state = state;
  return record;
}

std::optional<ProposalId> found(const ProposalContent& what, const std::vector<ProposalRecord>& known) {
  return match_proposals({what}, known).at(0).known;
}

TEST(OnePlace, IsTheSameBoxWithinWhatNoiseAndViewsChange) {
  EXPECT_TRUE(are_one_place(crate(0), crate(0)));
  EXPECT_TRUE(are_one_place(crate(0), crate(0.1))) << "most of it is common";
  EXPECT_TRUE(are_one_place(crate(0), box({0, 0, 0}, {0.3, 0.2, 0.08}))) << "its lower part, seen from elsewhere";
  EXPECT_FALSE(are_one_place(crate(0), crate(0.2))) << "most of it is elsewhere";
  EXPECT_FALSE(are_one_place(crate(0), crate(3)));
}

TEST(OnePlace, IsOfWhatShowsOnlyAnEdgeAndNotOfWhatIsMuchLarger) {
  EXPECT_TRUE(are_one_place(crate(0), box({0.2, 0, 0.01}, {0.09, 0.02, 0.18}))) << "one side, seen from its edge";
  EXPECT_FALSE(are_one_place(crate(0), box({-1, -1, 0}, {2, 2, 1}))) << "the room around it";
  EXPECT_FALSE(are_one_place(crate(0), box({0.33, 0, 0}, {0.02, 0.02, 0.02}))) << "a cup beside it";
}

TEST(OnePlace, IsKnownOfThingsWithoutThickness) {
  const auto poster = box({0, 0, 1}, {0.6, 0, 0.4});
  EXPECT_TRUE(are_one_place(poster, box({0.01, 0.008, 1.01}, {0.58, 0, 0.4}))) << "8 mm before itself by noise";
  EXPECT_FALSE(are_one_place(poster, box({0, 0.1, 1}, {0.6, 0, 0.4}))) << "another sheet 10 cm before it";
  EXPECT_TRUE(are_one_place(box({1, 1, 1}, {0, 0, 0}), box({1, 1, 1}, {0, 0, 0})));
  EXPECT_FALSE(are_one_place(Eigen::AlignedBox3d{}, crate(0))) << "an empty box is nowhere";
  EXPECT_FALSE(are_one_place(Eigen::AlignedBox3d{}, Eigen::AlignedBox3d{}));
}

TEST(OnePlace, EndsAtHalfOfTheSmallerBoxAndAtEightTimesItsSize) {
  // Grown by 2 cm on each side a box of 16 cm has 20 cm; at 10 cm exactly half is common.
  const auto cube = box({0, 0, 0}, {0.16, 0.16, 0.16});
  EXPECT_TRUE(are_one_place(cube, box({0.0999, 0, 0}, {0.16, 0.16, 0.16})));
  EXPECT_FALSE(are_one_place(cube, box({0.1001, 0, 0}, {0.16, 0.16, 0.16})));
  EXPECT_TRUE(are_one_place(cube, box({0, 0, 0}, {0.3599, 0.36, 0.36})));
  EXPECT_TRUE(are_one_place(box({0, 0, 0}, {0.361, 0.36, 0.36}), cube)) << "the other way round it is a part";
  EXPECT_FALSE(are_one_place(cube, box({0, 0, 0}, {0.361, 0.36, 0.36})));
}

TEST(MatchProposals, FindsTheSameKindAtTheSamePlace) {
  const std::vector known{record(4, crate(0)), record(7, crate(1))};
  EXPECT_EQ(found(content(crate(0.02)), known), 4u);
  EXPECT_EQ(found(content(crate(1.02)), known), 7u);
  EXPECT_EQ(found(content(crate(2)), known), std::nullopt);
  EXPECT_EQ(found(content(crate(0), ProposalKind::removal), known), std::nullopt) << "what comes is not what goes";
  EXPECT_EQ(found(content(crate(0), ProposalKind::move), known), std::nullopt);
  EXPECT_TRUE(match_proposals({}, known).empty());
}

TEST(MatchProposals, KeepsThePlaceWhileOnlyAnEdgeIsSeen) {
  const auto edge = box({0.2, 0, 0.01}, {0.09, 0.02, 0.18});
  auto known = record(4, crate(0));
  const auto from_its_edge = match_proposals({content(edge)}, {known}).at(0);
  EXPECT_EQ(from_its_edge.known, 4u);
  EXPECT_TRUE(from_its_edge.content.box_m.isApprox(crate(0)));
  known.content = from_its_edge.content;
  EXPECT_EQ(found(content(crate(0.01)), {known}), 4u) << "and seen whole again it is still the same";
  EXPECT_EQ(match_proposals({content(box({0, 0, 0}, {0.4, 0.2, 0.2}))}, {known}).at(0).content.box_m.sizes().x(), 0.4)
      << "more of it than before";
}

TEST(MatchProposals, FindsNothingThatWasAccepted) {
  const std::vector known{record(4, crate(0), ProposalState::accepted)};
  EXPECT_EQ(found(content(crate(0)), known), std::nullopt) << "what is measured there now is something else";
}

TEST(MatchProposals, GivesEachKnownOneOnceAndToTheMostAlike) {
  const std::vector known{record(1, crate(0)), record(2, crate(0.08))};
  const auto sightings = match_proposals({content(crate(0.09)), content(crate(0.01)), content(crate(0.05))}, known);
  EXPECT_EQ(sightings[0].known, 2u);
  EXPECT_EQ(sightings[1].known, 1u);
  EXPECT_EQ(sightings[2].known, std::nullopt) << "a third thing at the place of two";
  EXPECT_EQ(sightings[2].piece_of_rejected, std::nullopt);
}

TEST(MatchProposals, TakesTheLowerIdOfTwoThatAreEquallyAlike) {
  EXPECT_EQ(found(content(crate(0)), {record(9, crate(0)), record(3, crate(0))}), 3u);
}

TEST(MatchProposals, RejectsNotAllThatEverStandsWithinWhatWasRejected) {
  const auto room = box({-1, -1, 0}, {3, 3, 2});
  const std::vector known{record(3, room, ProposalState::rejected)};
  const auto inside = match_proposals({content(crate(0)), content(crate(0.5))}, known);
  for (const auto& sighting : inside) {
    EXPECT_FALSE(sighting.known);
    EXPECT_FALSE(sighting.piece_of_rejected);
  }
  EXPECT_EQ(found(content(crate(0)), {record(3, room)}), 3u) << "what is open may show as little as it likes";
  // 20 cm each way, and of that an eighth, with the margins of 2 cm.
  const std::vector cube{record(5, box({0, 0, 0}, {0.16, 0.16, 0.16}), ProposalState::rejected)};
  EXPECT_EQ(found(content(box({0, 0, 0}, {0.0601, 0.06, 0.06})), cube), 5u);
  EXPECT_EQ(found(content(box({0, 0, 0}, {0.0599, 0.06, 0.06})), cube), std::nullopt);
}

TEST(MatchProposals, KeepsWhatWasRejectedRejectedUntilItIsSomethingElse) {
  const std::vector known{record(3, crate(0), ProposalState::rejected)};
  EXPECT_EQ(found(content(crate(0.03)), known), 3u);
  EXPECT_EQ(found(content(crate(0.25)), known), std::nullopt);
  EXPECT_EQ(found(content(crate(0), ProposalKind::removal), known), std::nullopt);
  const auto pieces = match_proposals({content(crate(0)), content(box({0.15, 0, 0}, {0.15, 0.2, 0.2}))}, known);
  EXPECT_EQ(pieces[0].known, 3u);
  EXPECT_EQ(pieces[1].known, std::nullopt);
  EXPECT_EQ(pieces[1].piece_of_rejected, 3u) << "a second piece of it must not get in";
}

}  // namespace
}  // namespace meshloop
