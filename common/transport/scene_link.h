#pragma once
// The shared scene on the network: one writer (a station), any number of readers (devices). The only user of DDS.
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

/// A node's geometry, encoded by the codec.
struct NodePayload {
  NodeId id = 0;
  std::uint64_t epoch = 0;
  Revision revision = 0;
  Hash hash{};
  std::vector<std::byte> bytes;
};

inline constexpr std::size_t kMaxPayloadBytes = 1u << 20;
inline constexpr std::size_t kMaxManifestNodes = 65'536;

struct LinkOptions {
  /// Scenes with different names share a network without seeing each other. 1 to 64 characters.
  std::string scene;
  unsigned domain = 0;
  /// Bytes a second at which the writer sends at most (a KEEP_LAST writer never throttles by itself).
  double bytes_per_s = 20e6;
};

class SceneWriter {
 public:
  static Result<std::unique_ptr<SceneWriter>> create(const LinkOptions& options);
  virtual ~SceneWriter() = default;
  /// Geometry first, then the manifest that names it.
  virtual Status write(const NodePayload& payload) = 0;
  virtual Status write(const Manifest& manifest) = 0;
  /// Takes a node's geometry off the network.
  virtual Status dispose(NodeId id) = 0;
  /// How many readers there are now.
  [[nodiscard]] virtual int readers() const = 0;
};

/// What a reader took off the network, in order of arrival. Later ones replace earlier ones of the same node.
struct SceneSamples {
  std::vector<NodePayload> payloads;
  std::optional<Manifest> manifest;
};

class SceneReader {
 public:
  static Result<std::unique_ptr<SceneReader>> create(const LinkOptions& options);
  virtual ~SceneReader() = default;
  /// Waits until something arrives or the time is over (then empty). Samples that break a bound are counted and dropped.
  virtual SceneSamples take(std::chrono::milliseconds longest_wait) = 0;
  [[nodiscard]] virtual std::size_t rejected() const = 0;
};

}  // namespace meshloop
