#include "server/publish/publisher.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <set>

#include "common/base/clock.h"
#include "common/codec/mesh_codec.h"
#include "common/mesh/lattice.h"
#include "textured_wall.h"

namespace meshloop {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// A grid of 2 n^2 triangles on the lattice; `shape` makes each one different.
Submesh grid(std::uint32_t n, unsigned shape) {
  Submesh mesh;
  for (std::uint32_t y = 0; y <= n; ++y) {
    for (std::uint32_t x = 0; x <= n; ++x) {
      const unsigned height = (x * 7u + y * 13u + shape * 5u) % 32u;
      mesh.positions.emplace_back(kLatticeSpacing_m * 8.0f * static_cast<float>(x),
                                  kLatticeSpacing_m * 8.0f * static_cast<float>(y),
                                  kLatticeSpacing_m * static_cast<float>(height));
    }
  }
  for (std::uint32_t y = 0; y < n; ++y) {
    for (std::uint32_t x = 0; x < n; ++x) {
      const std::uint32_t a = y * (n + 1) + x;
      mesh.triangles.push_back({a, a + 1, a + n + 2});
      mesh.triangles.push_back({a, a + n + 2, a + n + 1});
    }
  }
  return mesh;
}

Node node_of(NodeId id, unsigned shape) {
  return make_node(id, fmt::format("node {}", id), grid(10, shape));
}

std::shared_ptr<const Model> model_of(Revision revision, std::vector<Node> nodes) {
  return std::make_shared<const Model>(Model{revision, std::move(nodes)});
}

// What left the publisher, in order.
struct Sent {
  std::vector<std::string> order;
  std::map<NodeId, NodePayload> payloads;
  Manifest manifest;
  /// The write after this many fails once.
  int fail_after = -1;
};

class RecordingWriter final : public SceneWriter {
 public:
  explicit RecordingWriter(Sent& sent) : sent_{sent} {}
  Status write(const NodePayload& payload) override {
    if (sent_.fail_after-- == 0) return fail("no network");
    sent_.order.push_back(fmt::format("payload {}", payload.id));
    sent_.payloads[payload.id] = payload;
    return {};
  }
  Status write(const Manifest& manifest) override {
    if (sent_.fail_after-- == 0) return fail("no network");
    sent_.order.push_back(fmt::format("manifest {}", manifest.revision));
    sent_.manifest = manifest;
    return {};
  }
  Status dispose(NodeId id) override {
    if (sent_.fail_after-- == 0) return fail("no network");
    sent_.order.push_back(fmt::format("dispose {}", id));
    return {};
  }
  [[nodiscard]] int readers() const override { return 0; }

 private:
  Sent& sent_;
};

class PublisherTest : public testing::Test {
 protected:
  Publisher make_publisher(std::uint64_t epoch = 7) {
    return Publisher{std::make_unique<RecordingWriter>(sent_), epoch};
  }
  Sent sent_;
};

TEST_F(PublisherTest, TheFirstCallSendsTheWholeModelGeometryFirst) {
  auto publisher = make_publisher();
  const auto model = model_of(3, {node_of(1, 1), node_of(2, 2), node_of(5, 3)});
  const auto report = publisher.publish(model, 99);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_THAT(sent_.order, ElementsAre("payload 1", "payload 2", "payload 5", "manifest 3"));
  EXPECT_EQ(report->nodes_sent, 3u);
  EXPECT_EQ(report->nodes_disposed, 0u);
  std::size_t raw_bytes = 0;
  std::size_t bytes = 0;
  for (const auto& node : model->nodes) raw_bytes += node.submesh->raw_bytes();
  for (const auto& [id, payload] : sent_.payloads) bytes += payload.bytes.size();
  EXPECT_EQ(report->raw_bytes, raw_bytes);
  EXPECT_EQ(report->bytes, bytes);
  EXPECT_GT(report->encode_ms, 0.0);
}

TEST_F(PublisherTest, TheManifestNamesEveryNodeAndItsPayload) {
  auto publisher = make_publisher();
  auto moved = node_of(2, 2);
  moved.T_world_node.translation() = Eigen::Vector3d{1, 2, 3};
  ASSERT_TRUE(publisher.publish(model_of(3, {node_of(1, 1), moved}), 99));
  EXPECT_EQ(sent_.manifest.epoch, 7u);
  EXPECT_EQ(sent_.manifest.revision, 3u);
  EXPECT_EQ(sent_.manifest.accepted_ns, 99);
  ASSERT_EQ(sent_.manifest.nodes.size(), 2u);
  EXPECT_EQ(sent_.manifest.nodes[1].name, "node 2");
  EXPECT_EQ(sent_.manifest.nodes[1].T_world_node.translation(), moved.T_world_node.translation());
  for (const auto& entry : sent_.manifest.nodes) {
    const auto& payload = sent_.payloads.at(entry.id);
    EXPECT_EQ(payload.epoch, 7u);
    EXPECT_EQ(payload.revision, 3u);
    EXPECT_EQ(entry.payload_hash, payload.hash);
    EXPECT_EQ(payload.hash, hash_of(payload.bytes));
    EXPECT_TRUE(decode(payload.bytes));
  }
}

TEST_F(PublisherTest, LaterCallsSendOnlyWhatChanged) {
  auto publisher = make_publisher();
  ASSERT_TRUE(publisher.publish(model_of(1, {node_of(1, 1), node_of(2, 2), node_of(3, 3)}), 0));
  const auto kept_hash = sent_.manifest.nodes[0].payload_hash;
  sent_.order.clear();
  const auto report = publisher.publish(model_of(2, {node_of(1, 1), node_of(3, 30), node_of(4, 4)}), 0);
  ASSERT_TRUE(report);
  EXPECT_THAT(sent_.order, ElementsAre("payload 3", "payload 4", "manifest 2", "dispose 2"));
  EXPECT_EQ(report->nodes_sent, 2u);
  EXPECT_EQ(report->nodes_disposed, 1u);
  EXPECT_EQ(sent_.manifest.nodes[0].payload_hash, kept_hash);
  EXPECT_EQ(sent_.manifest.nodes[1].payload_hash, sent_.payloads.at(3).hash);
}

TEST_F(PublisherTest, AMoveIsAManifestAlone) {
  auto publisher = make_publisher();
  ASSERT_TRUE(publisher.publish(model_of(1, {node_of(1, 1)}), 0));
  sent_.order.clear();
  auto moved = node_of(1, 1);
  moved.T_world_node.translation().x() = 0.02;
  const auto report = publisher.publish(model_of(2, {moved}), 0);
  ASSERT_TRUE(report);
  EXPECT_THAT(sent_.order, ElementsAre("manifest 2"));
  EXPECT_EQ(report->bytes, 0u);
  EXPECT_EQ(sent_.manifest.nodes[0].T_world_node.translation().x(), 0.02);
}

TEST_F(PublisherTest, AnUndoneRemovalSendsTheNodeAgain) {
  auto publisher = make_publisher();
  ASSERT_TRUE(publisher.publish(model_of(1, {node_of(1, 1), node_of(2, 2)}), 0));
  ASSERT_TRUE(publisher.publish(model_of(2, {node_of(1, 1)}), 0));
  sent_.order.clear();
  ASSERT_TRUE(publisher.publish(model_of(3, {node_of(1, 1), node_of(2, 2)}), 0));
  EXPECT_THAT(sent_.order, ElementsAre("payload 2", "manifest 3"));
}

TEST_F(PublisherTest, AnEmptyModelIsPublishedToo) {
  auto publisher = make_publisher();
  ASSERT_TRUE(publisher.publish(model_of(0, {}), 0));
  EXPECT_THAT(sent_.order, ElementsAre("manifest 0"));
}

TEST_F(PublisherTest, AfterAFailureTheNextCallSendsItAllAgain) {
  auto publisher = make_publisher();
  ASSERT_TRUE(publisher.publish(model_of(1, {node_of(1, 1), node_of(2, 2)}), 0));
  for (const int writes : {0, 1, 2}) {  // first payload, second payload, manifest
    sent_.fail_after = writes;
    const auto failed = publisher.publish(model_of(2, {node_of(1, 10), node_of(2, 20)}), 0);
    ASSERT_FALSE(failed);
    EXPECT_THAT(failed.error().message, HasSubstr("no network"));
    EXPECT_EQ(sent_.manifest.revision, 1u);
  }
  sent_.order.clear();
  ASSERT_TRUE(publisher.publish(model_of(2, {node_of(1, 10), node_of(2, 20)}), 0));
  EXPECT_THAT(sent_.order, ElementsAre("payload 1", "payload 2", "manifest 2"));
}

TEST_F(PublisherTest, ARemovalThatCannotBeTakenBackIsPublishedAllTheSame) {
  auto publisher = make_publisher();
  ASSERT_TRUE(publisher.publish(model_of(1, {node_of(1, 1), node_of(2, 2)}), 0));
  sent_.fail_after = 1;
  const auto report = publisher.publish(model_of(2, {node_of(1, 1)}), 0);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->nodes_disposed, 0u);
  EXPECT_EQ(sent_.manifest.revision, 2u);
}

TEST_F(PublisherTest, ANodeThatIsTooLargeIsRefusedBeforeAnythingIsSent) {
  auto publisher = make_publisher();
  Submesh noise = grid(600, 1);
  unsigned seed = 1;
  for (auto& position : noise.positions) {
    for (auto& coordinate : position) {
      seed = seed * 1664525u + 1013904223u;
      coordinate = kLatticeSpacing_m * static_cast<float>(seed >> 12);
    }
  }
  const auto report = publisher.publish(model_of(1, {node_of(1, 1), make_node(2, "noise", std::move(noise))}), 0);
  ASSERT_FALSE(report);
  EXPECT_THAT(report.error().message, HasSubstr("'noise'"));
  EXPECT_THAT(report.error().message, HasSubstr("split it"));
  EXPECT_THAT(sent_.order, ElementsAre());
}

/// As many triangles as a node of new surface or of an import may have, their noise larger than any sensor's, and as
/// much of a picture as a texture may be.
TEST_F(PublisherTest, TheLargestTextureFitsWithTheMostTriangles) {
  Submesh patch = grid(173, 1);
  ASSERT_NEAR(static_cast<double>(patch.triangles.size()), 60'000, 200);
  unsigned seed = 1;
  for (auto& position : patch.positions) {
    for (auto& coordinate : position) {
      seed = seed * 1664525u + 1013904223u;
      coordinate += kLatticeSpacing_m * static_cast<float>(seed >> 24);
    }
    position.z() += 1;
  }
  // What follows a JPEG's end is no part of its picture.
  auto jpeg = test::textured_wall().texture->jpeg;
  jpeg.resize(kMostTextureBytes);
  TextureProjection projection = TextureProjection::Zero();
  projection.leftCols<3>().setIdentity();
  patch.texture = make_projected_texture(std::move(jpeg), projection).value();
  auto publisher = make_publisher();
  const auto report = publisher.publish(model_of(1, {make_node(1, "patch", std::move(patch))}), 0);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_LE(report->bytes, kMaxPayloadBytes);
  std::printf("%zu bytes beside the texture\n", report->bytes - kMostTextureBytes);
}

TEST_F(PublisherTest, RefusesWhatIsNoModel) {
  auto publisher = make_publisher();
  EXPECT_FALSE(publisher.publish(nullptr, 0));
  EXPECT_FALSE(publisher.publish(model_of(1, {node_of(2, 2), node_of(1, 1)}), 0));
  EXPECT_FALSE(publisher.publish(model_of(1, {node_of(1, 1), node_of(1, 1)}), 0));
  EXPECT_FALSE(publisher.publish(model_of(1, {Node{1, "nothing", Pose::Identity(), nullptr, {}}}), 0));
  EXPECT_THAT(sent_.order, ElementsAre());
}

TEST_F(PublisherTest, CutsLongNamesBetweenCharacters) {
  auto publisher = make_publisher();
  auto node = node_of(1, 1);
  node.name = std::string(kMaxNameBytes - 1, 'x') + "ü and more";
  ASSERT_TRUE(publisher.publish(model_of(1, {node}), 0));
  EXPECT_EQ(sent_.manifest.nodes[0].name, std::string(kMaxNameBytes - 1, 'x'));
}

TEST(PublisherOverDds, WhatAReaderTakesIsWhatWasPublished) {
  LinkOptions options;
  options.scene = "publisher";
  options.domain = 1 + static_cast<unsigned>(getpid()) % 100;
  auto reader = SceneReader::create(options);
  ASSERT_TRUE(reader) << reader.error().message;
  auto writer = SceneWriter::create(options);
  ASSERT_TRUE(writer) << writer.error().message;
  Publisher publisher{std::move(*writer), 1};
  const auto report = publisher.publish(model_of(4, {node_of(1, 1), node_of(2, 2)}), wall_clock_ns());
  ASSERT_TRUE(report) << report.error().message;

  std::size_t bytes = 0;
  std::optional<Manifest> manifest;
  const Stopwatch waiting;
  while ((bytes < report->bytes || !manifest) && waiting.milliseconds() < 15'000) {
    const auto taken = (*reader)->take(std::chrono::milliseconds{100});
    for (const auto& payload : taken.payloads) bytes += payload.bytes.size();
    if (taken.manifest) manifest = taken.manifest;
  }
  EXPECT_EQ(bytes, report->bytes);
  ASSERT_TRUE(manifest);
  EXPECT_EQ(manifest->revision, 4u);
  EXPECT_EQ(publisher.readers(), 1);
  EXPECT_EQ((*reader)->rejected(), 0u);
}

}  // namespace
}  // namespace meshloop
