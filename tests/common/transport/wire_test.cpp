#include "common/transport/wire.h"

#include <gmock/gmock.h>

#include <limits>
#include <numbers>

#include "link_fixture.h"

namespace meshloop {
namespace {

using test::manifest_of;
using test::payload_of;
using testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Manifest one_node_manifest() {
  return manifest_of(3, 7, {payload_of(5, 3, 7)});
}

WireManifest wire_of(const Manifest& manifest) {
  return test::must(to_wire(manifest, "scene"));
}

TEST(Wire, APayloadComesBackAsItWas) {
  const auto payload = payload_of(5, 3, 7, kMaxPayloadBytes);
  const auto back = from_wire(test::must(to_wire(payload, "scene")), "scene");
  ASSERT_TRUE(back);
  EXPECT_EQ(back->id, 5u);
  EXPECT_EQ(back->epoch, 3u);
  EXPECT_EQ(back->revision, 7u);
  EXPECT_EQ(back->hash, payload.hash);
  EXPECT_EQ(back->bytes, payload.bytes);
}

TEST(Wire, AManifestComesBackAsItWas) {
  auto manifest = one_node_manifest();
  manifest.nodes[0].name = std::string(kMaxNameBytes, 'x');
  const Eigen::Vector3d axis = Eigen::Vector3d{1, -2, 0.5}.normalized();
  for (const double angle : {0.0, 1e-9, 1.0, std::numbers::pi, -3.0}) {
    manifest.nodes[0].T_world_node =
        make_pose({1.25, -3.5, 1000.125}, Eigen::Quaterniond{Eigen::AngleAxisd{angle, axis}});
    const auto back = from_wire(wire_of(manifest).sample, "scene");
    ASSERT_TRUE(back);
    EXPECT_EQ(back->epoch, 3u);
    EXPECT_EQ(back->revision, 7u);
    EXPECT_EQ(back->accepted_ns, 42);
    ASSERT_EQ(back->nodes.size(), 1u);
    EXPECT_EQ(back->nodes[0].id, 5u);
    EXPECT_EQ(back->nodes[0].name, manifest.nodes[0].name);
    EXPECT_EQ(back->nodes[0].payload_hash, manifest.nodes[0].payload_hash);
    EXPECT_TRUE(back->nodes[0].T_world_node.isApprox(manifest.nodes[0].T_world_node, 1e-14)) << angle;
  }
}

TEST(Wire, AnEmptySceneIsAManifestWithoutNodes) {
  const auto back = from_wire(wire_of(manifest_of(1, 0, {})).sample, "scene");
  ASSERT_TRUE(back);
  EXPECT_TRUE(back->nodes.empty());
}

TEST(Wire, NodesComeBackInTheOrderOfTheirIds) {
  const auto wire = wire_of(manifest_of(1, 1, {payload_of(9, 1, 1), payload_of(2, 1, 1), payload_of(4, 1, 1)}));
  const auto back = from_wire(wire.sample, "scene");
  ASSERT_TRUE(back);
  ASSERT_EQ(back->nodes.size(), 3u);
  EXPECT_EQ(back->nodes[0].id, 2u);
  EXPECT_EQ(back->nodes[1].id, 4u);
  EXPECT_EQ(back->nodes[2].id, 9u);
}

TEST(Wire, RefusesToSendWhatReadersWouldDrop) {
  EXPECT_FALSE(to_wire(payload_of(0, 1, 1), "scene"));
  EXPECT_FALSE(to_wire(payload_of(1, 1, 1, 0), "scene"));
  const auto large = to_wire(payload_of(1, 1, 1, kMaxPayloadBytes + 1), "scene");
  ASSERT_FALSE(large);
  EXPECT_THAT(large.error().message, HasSubstr("split the node"));

  auto manifest = one_node_manifest();
  manifest.nodes[0].name = std::string(kMaxNameBytes + 1, 'x');
  EXPECT_FALSE(to_wire(manifest, "scene"));
  manifest = one_node_manifest();
  manifest.nodes[0].T_world_node.translation().x() = kNaN;
  EXPECT_FALSE(to_wire(manifest, "scene"));
  manifest = one_node_manifest();
  manifest.nodes[0].T_world_node.linear() *= 1.001;
  EXPECT_FALSE(to_wire(manifest, "scene"));
  manifest = one_node_manifest();
  manifest.nodes[0].T_world_node.translation().y() = -10'001;
  EXPECT_FALSE(to_wire(manifest, "scene"));
  manifest.nodes.assign(kMaxManifestNodes + 1, one_node_manifest().nodes[0]);
  EXPECT_FALSE(to_wire(manifest, "scene"));
}

TEST(Wire, RefusesADamagedPayload) {
  auto payload = payload_of(5, 3, 7);
  auto sample = test::must(to_wire(payload, "scene"));
  sample.payload._buffer[500] ^= 1;
  EXPECT_FALSE(from_wire(sample, "scene"));
  sample.payload._buffer[500] ^= 1;
  EXPECT_TRUE(from_wire(sample, "scene"));
  sample.payload._length -= 1;
  EXPECT_FALSE(from_wire(sample, "scene"));
  sample.payload._length = 0;
  EXPECT_FALSE(from_wire(sample, "scene"));
}

TEST(Wire, RefusesAPayloadOfAnotherSceneOrSchema) {
  const auto payload = payload_of(5, 3, 7);
  auto sample = test::must(to_wire(payload, "scene"));
  EXPECT_FALSE(from_wire(sample, "another"));
  sample.schema_version += 1;
  const auto newer = from_wire(sample, "scene");
  ASSERT_FALSE(newer);
  EXPECT_THAT(newer.error().message, HasSubstr("update the older one"));
  sample = test::must(to_wire(payload, "scene"));
  sample.node = 0;
  EXPECT_FALSE(from_wire(sample, "scene"));
}

TEST(Wire, RefusesAManifestThatBreaksABound) {
  const auto manifest = one_node_manifest();
  const auto refused = [&](const auto& damage) {
    auto wire = wire_of(manifest);
    damage(wire.sample);
    return !from_wire(wire.sample, "scene");
  };
  EXPECT_FALSE(refused([](auto&) {}));
  EXPECT_TRUE(refused([](auto& sample) { sample.schema_version = 0; }));
  EXPECT_TRUE(refused([](auto& sample) { sample.scene[0] = 'S'; }));
  EXPECT_TRUE(refused([](auto& sample) { sample.nodes._length = kMaxManifestNodes + 1; }));
  EXPECT_TRUE(refused([](auto& sample) { sample.nodes._buffer[0].node = 0; }));
  EXPECT_TRUE(refused([](auto& sample) { sample.nodes._buffer[0].translation_m[1] = kNaN; }));
  EXPECT_TRUE(refused([](auto& sample) { sample.nodes._buffer[0].translation_m[1] = 1e300; }));
  EXPECT_TRUE(refused([](auto& sample) { sample.nodes._buffer[0].rotation_xyzw[3] = kNaN; }));
  EXPECT_TRUE(refused([](auto& sample) { sample.nodes._buffer[0].rotation_xyzw[3] = 0; }));
  EXPECT_TRUE(refused([](auto& sample) { sample.nodes._buffer[0].rotation_xyzw[3] = 1.001; }));
  EXPECT_TRUE(refused([](auto& sample) { memset(sample.nodes._buffer[0].name, 'x', 65); }));
}

TEST(Wire, RefusesAManifestThatNamesANodeTwice) {
  const auto wire = wire_of(manifest_of(1, 1, {payload_of(2, 1, 1), payload_of(3, 1, 1), payload_of(2, 1, 2)}));
  EXPECT_FALSE(from_wire(wire.sample, "scene"));
}

TEST(Wire, RefusesSceneNamesThatCannotTravel) {
  EXPECT_TRUE(check_scene_name("Küche 2"));
  EXPECT_TRUE(check_scene_name(std::string(kMaxNameBytes, 's')));
  for (const auto& name : {std::string{}, std::string(kMaxNameBytes + 1, 's'), std::string{"a*"}, std::string{"a?"},
                           std::string{"a\n"}, std::string{"a\0b", 3}}) {
    const auto ok = check_scene_name(name);
    ASSERT_FALSE(ok) << name;
    EXPECT_EQ(ok.error().kind, ErrorKind::usage);
  }
}

}  // namespace
}  // namespace meshloop
