#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

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

/// Sends what changed since the last model it sent: geometry of new and changed nodes, then the manifest, then disposes
/// of nodes that are gone. The cost follows the change. Called from one thread; encodes on two.
class Publisher {
 public:
  /// `epoch` is higher than that of every earlier Publisher of the scene (the store counts the starts).
  Publisher(std::unique_ptr<SceneWriter> writer, std::uint64_t epoch);
  /// The first call sends the whole model. When it fails nothing that clients show has changed, and the next call sends
  /// again what this one should have sent. A node whose encoding is larger than kMaxPayloadBytes is an error. Names are
  /// cut to kMaxNameBytes. `accepted_ns` is the wall clock of the acceptance (nanoseconds since 1970).
  [[nodiscard]] Result<PublishReport> publish(const std::shared_ptr<const Model>& model, std::int64_t accepted_ns);
  [[nodiscard]] int readers() const { return writer_->readers(); }

 private:
  std::size_t dispose_gone(const Model& before);

  std::unique_ptr<SceneWriter> writer_;
  std::uint64_t epoch_;
  std::shared_ptr<const Model> last_;
  /// As the last manifest named last_'s nodes.
  std::vector<ManifestEntry> entries_;
};

}  // namespace meshloop
