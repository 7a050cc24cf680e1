// A station and a device in two processes: samples really cross the network stack.
#include <gmock/gmock.h>
#include <meshloop.h>

#include "child_process.h"
#include "common/transport/scene_topics.h"
#include "common/transport/wire.h"
#include "link_fixture.h"

namespace meshloop {
namespace {

using namespace test;

constexpr std::size_t kNodes = 30;
constexpr int kSkipped = 77;

// Publishes a scene of 30 nodes of 100 kB and stays until it is killed.
int run_station(const LinkOptions& options, std::uint64_t epoch, std::size_t count) {
  auto writer = must(SceneWriter::create(options));
  std::vector<NodePayload> nodes;
  for (NodeId id = 1; id <= count; ++id) nodes.push_back(payload_of(id, epoch, epoch, 100'000));
  for (const auto& node : nodes) {
    if (!writer->write(node)) return 1;
  }
  if (!writer->write(manifest_of(epoch, epoch, nodes))) return 2;
  for (;;) pause();
}

bool is_complete(const Seen& seen, std::uint64_t epoch, std::size_t count) {
  if (!seen.manifest || seen.manifest->epoch != epoch || seen.manifest->nodes.size() != count) return false;
  for (const auto& node : seen.manifest->nodes) {
    const auto it = seen.payloads.find(node.id);
    if (it == seen.payloads.end() || it->second.hash != node.payload_hash) return false;
  }
  return true;
}

int catch_up(const LinkOptions& options) {
  auto reader = must(SceneReader::create(options));
  Seen seen;
  if (!take_until(*reader, seen, [](const Seen& s) { return is_complete(s, 1, kNodes); })) return 3;
  return reader->rejected() == 0 ? 0 : 4;
}

TEST(TwoProcesses, ALateDeviceCatchesUp) {
  const auto options = options_of("two processes");
  const ChildProcess station{[&] { return run_station(options, 1, kNodes); }};
  EXPECT_EQ(catch_up(options), 0);
}

TEST(TwoProcesses, WorkWhereThereIsOnlyTheLoopbackInterface) {
  const auto options = options_of("loopback");
  ChildProcess machine{[&] {
    if (!enter_network_with_loopback_only()) return kSkipped;
    const ChildProcess station{[&] { return run_station(options, 1, kNodes); }};
    return catch_up(options);
  }};
  const int status = machine.wait();
  if (status == kSkipped) GTEST_SKIP() << "this system allows no network namespaces";
  EXPECT_EQ(status, 0);
}

TEST(TwoProcesses, ADeviceFollowsAStationThatWasKilledAndStartedAgain) {
  const auto options = options_of("killed");
  ChildProcess device{[&] {
    auto reader = must(SceneReader::create(options));
    Seen seen;
    if (!take_until(*reader, seen, [](const Seen& s) { return is_complete(s, 1, kNodes); })) return 1;
    return take_until(*reader, seen, [](const Seen& s) { return is_complete(s, 2, kNodes - 10); }) ? 0 : 2;
  }};
  ChildProcess first{[&] { return run_station(options, 1, kNodes); }};
  std::this_thread::sleep_for(milliseconds{3000});
  first.send(SIGKILL);
  EXPECT_EQ(first.wait(), 128 + SIGKILL);
  const ChildProcess second{[&] { return run_station(options, 2, kNodes - 10); }};
  EXPECT_EQ(device.wait(), 0);
}

// Publishes ever new geometry while a reader has stopped reading.
int write_beside_a_dead_reader(const LinkOptions& options, const ChildProcess& reader) {
  auto writer = must(SceneWriter::create(options));
  if (!wait_until([&] { return writer->readers() == 1; })) return 1;
  reader.send(SIGSTOP);
  auto longest = milliseconds{0};
  for (Revision revision = 1; revision <= 12; ++revision) {
    const auto payload = payload_of(1 + revision % 3, 1, revision, kMaxPayloadBytes);
    const auto start = std::chrono::steady_clock::now();
    const auto written = writer->write(payload);
    longest = std::max(longest, std::chrono::duration_cast<milliseconds>(std::chrono::steady_clock::now() - start));
    if (!written && written.error().message.find("does not keep up") == std::string::npos) return 2;
  }
  std::fprintf(stderr, "longest write beside a dead reader: %lld ms\n", static_cast<long long>(longest.count()));
  const auto rate_wait = milliseconds{1 + static_cast<int>(1000.0 * kMaxPayloadBytes / options.bytes_per_s)};
  return longest <= kLongestWriteBlock + rate_wait + milliseconds{500} ? 0 : 3;
}

TEST(TwoProcesses, ADeadReaderDoesNotHoldTheWriterLongerThanStated) {
  const auto options = options_of("dead reader");
  const ChildProcess reader{[&] {
    auto reading = must(SceneReader::create(options));
    for (;;) reading->take(milliseconds{100});
    return 0;
  }};
  EXPECT_EQ(write_beside_a_dead_reader(options, reader), 0);
}

// What another program could put on the network: samples that our writer would refuse.
class RawWriter {
 public:
  explicit RawWriter(const LinkOptions& options)
      : topics_{must(create_topics(must(Domain::join(options.domain, {}))))},
        publisher_{must(create_publisher(topics_, options.scene))},
        manifests_{must(create_writer(publisher_, topics_.manifests))},
        mesh_nodes_{must(create_writer(publisher_, topics_.mesh_nodes))} {}

  void write(const meshloop_wire_Manifest& sample) const {
    if (dds_write(manifests_.get(), &sample) < 0) throw std::runtime_error("dds_write");
  }
  void write(const meshloop_wire_MeshNode& sample) const {
    if (!try_to_write(sample)) throw std::runtime_error("dds_write");
  }
  bool try_to_write(const meshloop_wire_MeshNode& sample) const { return dds_write(mesh_nodes_.get(), &sample) >= 0; }

 private:
  SceneTopics topics_;
  Entity publisher_;
  Entity manifests_;
  Entity mesh_nodes_;
};

int run_hostile_station(const LinkOptions& options) {
  const RawWriter writer{options};
  auto payload = payload_of(101, 1, 1);
  auto node = must(to_wire(payload, options.scene));
  node.payload._buffer[0] ^= 1;
  writer.write(node);
  node.node = 102;
  node.schema_version = 9;
  writer.write(node);
  auto manifest = must(to_wire(manifest_of(1, 1, {payload}), options.scene));
  manifest.sample.nodes._buffer[0].rotation_xyzw[0] = 2;
  writer.write(manifest.sample);
  // Beyond the bound of the type: DDS itself lets it not pass, on one side or the other.
  auto large = bytes_of(kMaxPayloadBytes + 1, 1);
  node = must(to_wire(payload_of(103, 1, 1), options.scene));
  node.payload = {kMaxPayloadBytes + 1, kMaxPayloadBytes + 1, reinterpret_cast<std::uint8_t*>(large.data()), false};
  std::fprintf(stderr, "DDS %s to write a payload beyond the bound\n",
               writer.try_to_write(node) ? "agrees" : "refuses");
  for (;;) pause();
}

TEST(TwoProcesses, SamplesThatBreakABoundAreCountedAndTheRestGoesOn) {
  const auto options = options_of("hostile");
  const ChildProcess hostile{[&] { return run_hostile_station(options); }};
  const ChildProcess station{[&] {
    raise(SIGSTOP);  // the manifests of both are one instance: theirs must not arrive after ours
    return run_station(options, 2, 5);
  }};
  auto reader = must(SceneReader::create(options));
  Seen seen;
  EXPECT_TRUE(take_until(*reader, seen, [&](const Seen&) { return reader->rejected() >= 3; }));
  station.send(SIGCONT);
  EXPECT_TRUE(take_until(*reader, seen, [](const Seen& s) { return is_complete(s, 2, 5); }));
  EXPECT_EQ(seen.payloads.size(), 5u);
  EXPECT_EQ(reader->rejected(), 3u);
}

}  // namespace
}  // namespace meshloop
