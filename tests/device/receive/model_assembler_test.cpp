#include <gmock/gmock.h>

#include "device/receive/scene_receiver.h"
#include "station.h"
#include "textured_wall.h"

namespace meshloop {
namespace {

using namespace test;

SceneSamples samples(std::vector<NodePayload> payloads, std::optional<Manifest> manifest = {}) {
  return {std::move(payloads), std::move(manifest)};
}

class ModelAssemblerTest : public testing::Test {
 protected:
  NodePayload a_ = payload_of(1, patch(6, 1), 1, 1);
  NodePayload b_ = payload_of(2, patch(7, 2), 1, 1);
  NodePayload b_changed_ = payload_of(2, patch(8, 3), 1, 2);
  ModelAssembler assembler_;
};

TEST_F(ModelAssemblerTest, GivesTheModelWhenTheLastPieceIsThere) {
  EXPECT_EQ(assembler_.add(samples({a_})), nullptr);
  auto manifest = manifest_of(1, 1, {a_, b_});
  manifest.nodes[1].T_world_node.translation().y() = 2.5;
  EXPECT_EQ(assembler_.add(samples({}, manifest)), nullptr);
  const auto received = assembler_.add(samples({b_}));
  ASSERT_NE(received, nullptr);
  EXPECT_EQ(received->epoch, 1u);
  EXPECT_EQ(received->accepted_ns, manifest.accepted_ns);
  EXPECT_GE(received->complete_ns, manifest.accepted_ns);
  EXPECT_GT(received->decode_ms, 0.0);
  const auto& model = *received->model;
  EXPECT_EQ(model.revision, 1u);
  ASSERT_EQ(model.nodes.size(), 2u);
  EXPECT_EQ(model.nodes[0].id, 1u);
  EXPECT_EQ(model.nodes[1].name, "node 2");
  EXPECT_EQ(model.nodes[1].T_world_node.translation().y(), 2.5);
  EXPECT_EQ(shape_of(*model.nodes[1].submesh), shape_of(patch(7, 2)));
  EXPECT_EQ(model.nodes[1].hash, content_hash(*model.nodes[1].submesh));
  EXPECT_EQ(assembler_.counts().payloads, 2u);
  EXPECT_EQ(assembler_.counts().rejected, 0u);
}

TEST_F(ModelAssemblerTest, TexturesArriveWithTheirNodes) {
  const Submesh wall = textured_wall();
  const auto payload = payload_of(3, wall, 1, 1);
  const auto received = assembler_.add(samples({a_, payload}, manifest_of(1, 1, {a_, payload})));
  ASSERT_NE(received, nullptr);
  const auto& texture = received->model->find(3)->submesh->texture;
  ASSERT_TRUE(texture);
  EXPECT_EQ(texture->jpeg, wall.texture->jpeg);
  EXPECT_EQ(texture->projection, wall.texture->projection);
  EXPECT_FALSE(received->model->find(1)->submesh->texture);
}

TEST_F(ModelAssemblerTest, ADamagedTextureIsRejectedWithItsPayload) {
  auto payload = payload_of(3, textured_wall(), 1, 1);
  payload.bytes.resize(payload.bytes.size() - 200);
  payload.hash = hash_of(payload.bytes);
  EXPECT_EQ(assembler_.add(samples({payload}, manifest_of(1, 1, {payload}))), nullptr);
  EXPECT_EQ(assembler_.counts().rejected, 1u);
}

TEST_F(ModelAssemblerTest, TheOrderOfArrivalDoesNotMatter) {
  EXPECT_EQ(assembler_.add(samples({}, manifest_of(1, 1, {a_, b_}))), nullptr);
  EXPECT_NE(assembler_.add(samples({b_, a_})), nullptr);
  ModelAssembler all_at_once;
  EXPECT_NE(all_at_once.add(samples({b_, a_}, manifest_of(1, 1, {a_, b_}))), nullptr);
}

TEST_F(ModelAssemblerTest, GivesEachRevisionOnce) {
  const auto manifest = manifest_of(1, 1, {a_});
  EXPECT_NE(assembler_.add(samples({a_}, manifest)), nullptr);
  EXPECT_EQ(assembler_.add(samples({a_}, manifest)), nullptr);
  EXPECT_EQ(assembler_.add(samples({}, manifest)), nullptr);
}

TEST_F(ModelAssemblerTest, AnUnchangedNodeIsNotDecodedAgainAndKeepsItsGeometry) {
  const auto first = assembler_.add(samples({a_, b_}, manifest_of(1, 1, {a_, b_})));
  const auto second = assembler_.add(samples({b_changed_}, manifest_of(1, 2, {a_, b_changed_})));
  ASSERT_NE(second, nullptr);
  EXPECT_EQ(second->model->nodes[0].submesh, first->model->nodes[0].submesh);
  EXPECT_NE(second->model->nodes[1].submesh, first->model->nodes[1].submesh);
}

TEST_F(ModelAssemblerTest, AMovedNodeNeedsNoPayload) {
  const auto first = assembler_.add(samples({a_}, manifest_of(1, 1, {a_})));
  auto moved = manifest_of(1, 2, {a_});
  moved.nodes[0].T_world_node.translation().x() = 0.02;
  const auto second = assembler_.add(samples({}, moved));
  ASSERT_NE(second, nullptr);
  EXPECT_EQ(second->model->nodes[0].submesh, first->model->nodes[0].submesh);
  EXPECT_EQ(second->model->nodes[0].T_world_node.translation().x(), 0.02);
  EXPECT_EQ(second->decode_ms, 0.0);
}

TEST_F(ModelAssemblerTest, ARemovedNodeNeverComesBack) {
  assembler_.add(samples({a_, b_}, manifest_of(1, 1, {a_, b_})));
  const auto removed = assembler_.add(samples({}, manifest_of(1, 2, {a_})));
  ASSERT_NE(removed, nullptr);
  EXPECT_EQ(removed->model->nodes.size(), 1u);
  EXPECT_EQ(assembler_.add(samples({b_})), nullptr);
  EXPECT_EQ(assembler_.add(samples({b_}, manifest_of(1, 1, {a_, b_}))), nullptr);
}

TEST_F(ModelAssemblerTest, AnOlderManifestIsIgnored) {
  ASSERT_NE(assembler_.add(samples({a_}, manifest_of(2, 5, {a_}))), nullptr);
  EXPECT_EQ(assembler_.add(samples({b_}, manifest_of(2, 4, {b_}))), nullptr);
  EXPECT_EQ(assembler_.add(samples({b_}, manifest_of(1, 9, {b_}))), nullptr);
}

TEST_F(ModelAssemblerTest, ARestartedStationWithTheSameContentIsCompleteAtOnce) {
  const auto before = assembler_.add(samples({a_, b_}, manifest_of(1, 5, {a_, b_})));
  const auto after = assembler_.add(samples({}, manifest_of(2, 5, {a_, b_})));
  ASSERT_NE(after, nullptr);
  EXPECT_EQ(after->epoch, 2u);
  EXPECT_EQ(after->decode_ms, 0.0);
  EXPECT_EQ(after->model->nodes[1].submesh, before->model->nodes[1].submesh);
}

TEST_F(ModelAssemblerTest, ARestartedStationMayFallBackToAnOlderRevision) {
  ASSERT_NE(assembler_.add(samples({a_, b_}, manifest_of(1, 5, {a_, b_}))), nullptr);
  const auto after = assembler_.add(samples({}, manifest_of(2, 3, {a_})));
  ASSERT_NE(after, nullptr);
  EXPECT_EQ(after->model->revision, 3u);
}

TEST_F(ModelAssemblerTest, AnEmptySceneIsComplete) {
  const auto received = assembler_.add(samples({}, manifest_of(1, 0, {})));
  ASSERT_NE(received, nullptr);
  EXPECT_TRUE(received->model->nodes.empty());
}

TEST_F(ModelAssemblerTest, TwoNodesMayShareOnePayload) {
  auto twin = a_;
  twin.id = 9;
  const auto received = assembler_.add(samples({a_}, manifest_of(1, 1, {a_, twin})));
  ASSERT_NE(received, nullptr);
  EXPECT_EQ(received->model->nodes[0].submesh, received->model->nodes[1].submesh);
}

TEST_F(ModelAssemblerTest, ADamagedPayloadIsCountedAndTheModelStays) {
  ASSERT_NE(assembler_.add(samples({a_, b_}, manifest_of(1, 1, {a_, b_}))), nullptr);
  auto damaged = b_changed_;
  damaged.bytes[damaged.bytes.size() / 2] ^= std::byte{1};
  EXPECT_EQ(assembler_.add(samples({damaged}, manifest_of(1, 2, {a_, b_changed_}))), nullptr);
  EXPECT_EQ(assembler_.counts().rejected, 1u);
  EXPECT_NE(assembler_.add(samples({b_changed_})), nullptr);
}

TEST_F(ModelAssemblerTest, BytesThatAreNoMeshAreCountedAndTheModelStays) {
  NodePayload nonsense{1, 1, 2, {}, std::vector<std::byte>(500, std::byte{0x44})};
  nonsense.hash = hash_of(nonsense.bytes);
  EXPECT_EQ(assembler_.add(samples({nonsense}, manifest_of(1, 2, {nonsense}))), nullptr);
  EXPECT_EQ(assembler_.counts().rejected, 1u);
  NodePayload empty{1, 1, 2, hash_of({}), {}};
  EXPECT_EQ(assembler_.add(samples({empty}, manifest_of(1, 3, {empty}))), nullptr);
  EXPECT_EQ(assembler_.counts().rejected, 2u);
  EXPECT_NE(assembler_.add(samples({a_}, manifest_of(1, 4, {a_}))), nullptr);
}

TEST_F(ModelAssemblerTest, BytesThatAreNoMeshAreTriedOnceAndCountedEachTime) {
  NodePayload nonsense{1, 1, 2, {}, std::vector<std::byte>(500, std::byte{0x44})};
  nonsense.hash = hash_of(nonsense.bytes);
  testing::internal::CaptureStderr();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(assembler_.add(samples({nonsense})), nullptr);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_EQ(assembler_.counts().rejected, 3u);
  EXPECT_EQ(said.find("does not decode"), said.rfind("does not decode")) << said;
  EXPECT_NE(said.find("does not decode"), std::string::npos);
}

TEST_F(ModelAssemblerTest, APayloadOfALaterRevisionWaitsForItsManifest) {
  ASSERT_NE(assembler_.add(samples({a_, b_}, manifest_of(1, 1, {a_, b_}))), nullptr);
  const auto c = payload_of(3, patch(5, 4), 1, 3);
  EXPECT_EQ(assembler_.add(samples({c})), nullptr);
  EXPECT_NE(assembler_.add(samples({}, manifest_of(1, 2, {a_}))), nullptr);
  EXPECT_NE(assembler_.add(samples({}, manifest_of(1, 3, {a_, c}))), nullptr);
}

TEST_F(ModelAssemblerTest, PendingTexturesCountAsTheirJpegs) {
  const Submesh wall = textured_wall();
  const std::size_t kept = wall.geometry_bytes() + wall.texture->jpeg.size();
  ASSERT_LT(kept, wall.raw_bytes());
  const auto payload = payload_of(3, wall, 1, 1);
  ModelAssembler large_enough{kept};
  EXPECT_EQ(large_enough.add(samples({payload})), nullptr);
  EXPECT_NE(large_enough.add(samples({}, manifest_of(1, 1, {payload}))), nullptr);
  ModelAssembler too_small{kept - 1};
  EXPECT_EQ(too_small.add(samples({payload})), nullptr);
  EXPECT_EQ(too_small.add(samples({}, manifest_of(1, 1, {payload}))), nullptr);
}

TEST_F(ModelAssemblerTest, PendingPayloadsAreBoundedAndTheOldestGoFirst) {
  const std::size_t one = must(decode(a_.bytes)).raw_bytes();
  ModelAssembler small{3 * one};
  std::vector<NodePayload> nodes;
  for (NodeId id = 1; id <= 5; ++id) nodes.push_back(payload_of(id, patch(6, static_cast<unsigned>(10 + id)), 1, 1));
  EXPECT_EQ(small.add(samples(nodes)), nullptr);
  const std::vector<NodePayload> youngest{nodes[2], nodes[3], nodes[4]};
  EXPECT_NE(small.add(samples({}, manifest_of(1, 1, youngest))), nullptr);
  EXPECT_EQ(small.add(samples({}, manifest_of(1, 2, nodes))), nullptr);
  EXPECT_NE(small.add(samples({nodes[0], nodes[1]})), nullptr) << "what a manifest names has no such bound";
}

}  // namespace
}  // namespace meshloop
