#pragma once
// The shared scene on the network: one writer (a station), any number of readers (devices). The only user of DDS.
// What crosses the network, with all bounds, stands in proto/meshloop.idl.
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/hash.h"
#include "common/base/result.h"
#include "common/geometry/pose.h"
#include "common/mesh/model.h"

namespace meshloop {

/// One node as the manifest names it. A node that only moved travels in the manifest alone.
struct ManifestEntry {
  NodeId id = 0;
  std::string name;
  Pose T_world_node = Pose::Identity();
  /// Of the payload's bytes.
  Hash payload_hash{};
};

/// What the scene is made of at one revision. Decides when a client is complete, and what is gone.
struct Manifest {
  /// Grows with every start of the station (persisted by its store), so that a client knows old samples from new ones.
  std::uint64_t epoch = 0;
  Revision revision = 0;
  /// Wall clock of the acceptance that made this revision (nanoseconds since 1970).
  std::int64_t accepted_ns = 0;
  std::vector<ManifestEntry> nodes;
};

/// A node's geometry, encoded by the codec. `bytes` are opaque here; `hash` is of them.
struct NodePayload {
  NodeId id = 0;
  std::uint64_t epoch = 0;
  Revision revision = 0;
  Hash hash{};
  std::vector<std::byte> bytes;
};

inline constexpr std::size_t kMaxPayloadBytes = 1u << 20;
inline constexpr std::size_t kMaxManifestNodes = 65'536;
/// Of a node's or a scene's name, in UTF-8.
inline constexpr std::size_t kMaxNameBytes = 64;
/// Longer than this no write waits for readers that do not keep up, beyond the time that `bytes_per_s` asks for.
inline constexpr std::chrono::milliseconds kLongestWriteBlock{2000};

struct LinkOptions {
  /// Scenes with different names share a network without seeing each other. 1 to 64 bytes of UTF-8, without control
  /// characters and the wildcards * and ?.
  std::string scene;
  /// 0 to 230. The same number at the station and at its devices.
  unsigned domain = 0;
  /// Bytes a second at which the writer sends at most (a KEEP_LAST writer never throttles by itself). At least 10,000.
  double bytes_per_s = 20e6;
  /// Hosts (names or addresses, each with an optional :port) that are asked where multicast does not reach them; those
  /// of the environment variable MESHLOOP_PEERS (separated by commas) are added. This machine is always asked. The
  /// first link of a process on a domain decides for the later ones.
  std::vector<std::string> peers;
};

/// One scene's writing end. One thread at a time. What was written stays on the network for readers that come late for
/// as long as the writer lives; readers keep what they have when it dies.
class SceneWriter {
 public:
  /// Fails with a sentence when the options are out of bounds, or the network cannot be used.
  [[nodiscard]] static Result<std::unique_ptr<SceneWriter>> create(const LinkOptions& options);
  virtual ~SceneWriter() = default;
  /// Geometry first, then the manifest that names it. Refuses what readers would drop. Waits as long as `bytes_per_s`
  /// asks for while there are readers, and then at most kLongestWriteBlock; a write that failed can be repeated.
  [[nodiscard]] virtual Status write(const NodePayload& payload) = 0;
  [[nodiscard]] virtual Status write(const Manifest& manifest) = 0;
  /// Takes a node's geometry off the network.
  [[nodiscard]] virtual Status dispose(NodeId id) = 0;
  /// How many readers there are now. Any thread.
  [[nodiscard]] virtual int readers() const = 0;
};

/// What a reader took off the network, in order of arrival. Later ones replace earlier ones of the same node.
struct SceneSamples {
  std::vector<NodePayload> payloads;
  std::optional<Manifest> manifest;
};

/// One scene's reading end. take() is called by one thread at a time, rejected() by any.
class SceneReader {
 public:
  [[nodiscard]] static Result<std::unique_ptr<SceneReader>> create(const LinkOptions& options);
  virtual ~SceneReader() = default;
  /// Waits until something arrives or the time is over (then empty). Samples that break a bound of proto/meshloop.idl,
  /// whose payload does not have its hash, or whose transforms are not rigid, are counted and dropped. What comes back
  /// holds at most 64 MiB of payloads (the rest follows at the next call); a manifest's nodes are in the order of their
  /// ids, each id once.
  virtual SceneSamples take(std::chrono::milliseconds longest_wait) = 0;
  [[nodiscard]] virtual std::size_t rejected() const = 0;
};

}  // namespace meshloop
