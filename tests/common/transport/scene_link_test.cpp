#include "common/transport/scene_link.h"

#include <gmock/gmock.h>

#include "link_fixture.h"
#include "sanitized.h"

namespace meshloop {
namespace {

using namespace test;
using testing::HasSubstr;

bool has_manifest(const Seen& seen) {
  return seen.manifest.has_value();
}

std::function<bool(const Seen&)> has_revision(std::uint64_t epoch, Revision revision) {
  return [=](const Seen& seen) {
    return seen.manifest && seen.manifest->epoch == epoch && seen.manifest->revision == revision;
  };
}

std::function<bool(const Seen&)> has_nodes(std::size_t count) {
  return [=](const Seen& seen) { return seen.payloads.size() >= count; };
}

TEST(SceneLink, ALateReaderGetsTheNewestOfEverything) {
  auto writer = must(SceneWriter::create(options_of("late")));
  std::vector<NodePayload> nodes;
  for (NodeId id = 1; id <= 20; ++id) nodes.push_back(payload_of(id, 1, 1, 30'000));
  for (const auto& node : nodes) ASSERT_TRUE(writer->write(node));
  nodes[3] = payload_of(4, 1, 2, kMaxPayloadBytes);
  ASSERT_TRUE(writer->write(nodes[3]));
  ASSERT_TRUE(writer->write(manifest_of(1, 1, nodes)));
  ASSERT_TRUE(writer->write(manifest_of(1, 2, nodes)));

  auto reader = must(SceneReader::create(options_of("late")));
  Seen seen;
  ASSERT_TRUE(take_until(*reader, seen, [](const Seen& s) { return s.payloads.size() == 20 && s.manifest; }));
  EXPECT_EQ(seen.manifest->revision, 2u);
  ASSERT_EQ(seen.manifest->nodes.size(), 20u);
  for (const auto& node : nodes) EXPECT_EQ(seen.payloads.at(node.id).bytes, node.bytes);
  EXPECT_EQ(reader->rejected(), 0u);
}

TEST(SceneLink, AReaderThatWaitsSeesAnUpdateAtOnce) {
  auto reader = must(SceneReader::create(options_of("live")));
  auto writer = must(SceneWriter::create(options_of("live")));
  ASSERT_TRUE(wait_until([&] { return writer->readers() == 1; }));
  const auto node = payload_of(1, 1, 1);
  ASSERT_TRUE(writer->write(node));
  Seen seen;
  const auto start = std::chrono::steady_clock::now();
  ASSERT_TRUE(take_until(*reader, seen, has_nodes(1)));
  EXPECT_LT(std::chrono::steady_clock::now() - start, milliseconds{1000});
}

TEST(SceneLink, TakeComesBackEmptyWhenTheTimeIsOver) {
  auto reader = must(SceneReader::create(options_of("nobody")));
  const auto start = std::chrono::steady_clock::now();
  const auto taken = reader->take(milliseconds{100});
  EXPECT_GE(std::chrono::steady_clock::now() - start, milliseconds{95});
  EXPECT_TRUE(taken.payloads.empty());
  EXPECT_FALSE(taken.manifest);
}

TEST(SceneLink, ARestartedWriterReplacesWhatItsPredecessorSaid) {
  auto reader = must(SceneReader::create(options_of("restart")));
  Seen seen;
  auto first = must(SceneWriter::create(options_of("restart")));
  const auto old_node = payload_of(1, 1, 9);
  ASSERT_TRUE(first->write(old_node));
  ASSERT_TRUE(first->write(manifest_of(1, 9, {old_node})));
  ASSERT_TRUE(take_until(*reader, seen, has_revision(1, 9)));
  first.reset();

  auto second = must(SceneWriter::create(options_of("restart")));
  const auto new_node = payload_of(1, 2, 3);
  ASSERT_TRUE(second->write(new_node));
  ASSERT_TRUE(second->write(manifest_of(2, 3, {new_node})));
  ASSERT_TRUE(take_until(*reader, seen, has_revision(2, 3)));
  ASSERT_TRUE(take_until(*reader, seen, [&](const Seen& s) { return s.payloads.at(1).hash == new_node.hash; }));
  EXPECT_EQ(reader->rejected(), 0u);
}

TEST(SceneLink, AReaderKeepsQuietWhenItsWriterGoesAway) {
  auto reader = must(SceneReader::create(options_of("gone")));
  auto writer = must(SceneWriter::create(options_of("gone")));
  const auto node = payload_of(1, 1, 1);
  ASSERT_TRUE(writer->write(node));
  ASSERT_TRUE(writer->write(manifest_of(1, 1, {node})));
  Seen seen;
  ASSERT_TRUE(take_until(*reader, seen, has_manifest));
  ASSERT_TRUE(take_until(*reader, seen, has_nodes(1)));
  writer.reset();
  for (int i = 0; i < 5; ++i) {
    const auto taken = reader->take(milliseconds{50});
    EXPECT_TRUE(taken.payloads.empty());
    EXPECT_FALSE(taken.manifest);
  }
  EXPECT_EQ(reader->rejected(), 0u);
}

TEST(SceneLink, ADisposedNodeNeverReachesALateReader) {
  auto writer = must(SceneWriter::create(options_of("disposed")));
  const auto stays = payload_of(1, 1, 1);
  const auto goes = payload_of(2, 1, 1);
  ASSERT_TRUE(writer->write(stays));
  ASSERT_TRUE(writer->write(goes));
  ASSERT_TRUE(writer->write(manifest_of(1, 2, {stays})));
  ASSERT_TRUE(writer->dispose(goes.id));

  auto reader = must(SceneReader::create(options_of("disposed")));
  Seen seen;
  ASSERT_TRUE(take_until(*reader, seen, [](const Seen& s) { return s.manifest && s.payloads.contains(1); }));
  take_until(*reader, seen, has_nodes(2), milliseconds{300});
  EXPECT_FALSE(seen.payloads.contains(2));
  EXPECT_EQ(reader->rejected(), 0u);
}

TEST(SceneLink, ScenesOnOneDomainDoNotSeeEachOther) {
  auto here = must(SceneReader::create(options_of("kitchen")));
  auto there = must(SceneReader::create(options_of("kitchen 2")));
  auto writer = must(SceneWriter::create(options_of("kitchen")));
  ASSERT_TRUE(writer->write(payload_of(1, 1, 1)));
  Seen seen;
  ASSERT_TRUE(take_until(*here, seen, has_nodes(1)));
  Seen nothing;
  EXPECT_FALSE(take_until(*there, nothing, has_nodes(1), milliseconds{300}));
  EXPECT_EQ(writer->readers(), 1);
  EXPECT_EQ(there->rejected(), 0u);
}

TEST(SceneLink, ADamagedPayloadIsCountedAndDropped) {
  auto reader = must(SceneReader::create(options_of("damaged")));
  auto writer = must(SceneWriter::create(options_of("damaged")));
  auto damaged = payload_of(1, 1, 1);
  damaged.bytes[10] ^= std::byte{4};
  const auto good = payload_of(2, 1, 1);
  ASSERT_TRUE(writer->write(damaged));
  ASSERT_TRUE(writer->write(good));
  Seen seen;
  ASSERT_TRUE(take_until(*reader, seen, [&](const Seen&) { return reader->rejected() == 1; }));
  ASSERT_TRUE(take_until(*reader, seen, has_nodes(1)));
  EXPECT_TRUE(seen.payloads.contains(2));
  EXPECT_FALSE(seen.payloads.contains(1));
}

TEST(SceneLink, TheWriterKeepsItsRateWhileSomebodyReads) {
  auto options = options_of("paced");
  options.bytes_per_s = 4e6;
  auto reader = must(SceneReader::create(options));
  auto writer = must(SceneWriter::create(options));
  ASSERT_TRUE(wait_until([&] { return writer->readers() == 1; }));
  const auto start = std::chrono::steady_clock::now();
  for (NodeId id = 1; id <= 3; ++id) ASSERT_TRUE(writer->write(payload_of(id, 1, 1, kMaxPayloadBytes)));
  const double elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  EXPECT_GE(elapsed_s, 2 * static_cast<double>(kMaxPayloadBytes) / 4e6 - 0.01);
  Seen seen;
  EXPECT_TRUE(take_until(*reader, seen, has_nodes(3)));
}

TEST(SceneLink, TheWriterDoesNotWaitWhenNobodyReads) {
  auto options = options_of("unread");
  options.bytes_per_s = 10e3;
  auto writer = must(SceneWriter::create(options));
  const auto start = std::chrono::steady_clock::now();
  for (NodeId id = 1; id <= 5; ++id) ASSERT_TRUE(writer->write(payload_of(id, 1, 1, kMaxPayloadBytes)));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds{10});
}

TEST(SceneLink, RefusesOptionsThatCannotWork) {
  EXPECT_FALSE(SceneWriter::create(options_of("")));
  EXPECT_FALSE(SceneReader::create(options_of("*")));
  EXPECT_FALSE(SceneReader::create(options_of("scene", 231)));
  auto options = options_of("scene");
  for (const double rate : {0.0, -1.0, 9999.0, std::numeric_limits<double>::quiet_NaN()}) {
    options.bytes_per_s = rate;
    EXPECT_FALSE(SceneWriter::create(options)) << rate;
  }
}

TEST(SceneLink, AManifestWithTheMostNodesArrives) {
  auto reader = must(SceneReader::create(options_of("large")));
  auto writer = must(SceneWriter::create(options_of("large")));
  Manifest manifest{1, 1, 0, {}};
  const std::size_t count = kSanitized ? 5'000 : kMaxManifestNodes;
  manifest.nodes.resize(count);
  for (std::size_t i = 0; i < manifest.nodes.size(); ++i) manifest.nodes[i].id = i + 1;
  ASSERT_TRUE(writer->write(manifest));
  Seen seen;
  ASSERT_TRUE(take_until(*reader, seen, has_manifest, milliseconds{30'000}));
  EXPECT_EQ(seen.manifest->nodes.size(), count);
  EXPECT_EQ(seen.manifest->nodes.back().id, count);
}

}  // namespace
}  // namespace meshloop
