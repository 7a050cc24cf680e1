#pragma once
#include <cstdint>
#include <memory>

#include "common/base/result.h"
#include "common/mesh/model.h"
#include "common/transport/scene_link.h"

namespace meshloop {

struct PublishReport {
  std::size_t nodes_sent = 0;
  std::size_t nodes_disposed = 0;
  /// Encoded bytes of the nodes sent, and what they would be uncompressed.
  std::size_t bytes = 0;
  std::size_t raw_bytes = 0;
  double encode_ms = 0;
};

/// Sends what changed since the last model it sent: geometry of new and changed nodes, then the manifest, then disposes of
/// nodes that are gone. The cost follows the change. One thread.
class Publisher {
 public:
  Publisher(std::unique_ptr<SceneWriter> writer, std::uint64_t epoch);
  Result<PublishReport> publish(const std::shared_ptr<const Model>& model, std::int64_t accepted_ns);
  [[nodiscard]] int readers() const { return writer_->readers(); }

 private:
  std::unique_ptr<SceneWriter> writer_;
  std::uint64_t epoch_;
  std::shared_ptr<const Model> last_;
  std::vector<ManifestEntry> entries_;
};

}  // namespace meshloop
