#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>

#include "common/base/result.h"
#include "common/mesh/model.h"
#include "common/transport/scene_link.h"

namespace meshloop {

/// A complete model as it came from the station.
struct ReceivedModel {
  std::shared_ptr<const Model> model;
  std::uint64_t epoch = 0;
  std::int64_t accepted_ns = 0;
  /// Wall clock when the model was complete, and how long decoding its new nodes took.
  std::int64_t complete_ns = 0;
  double decode_ms = 0;
};

struct ReceiveCounts {
  /// Whole payloads that arrived, whether they were needed or not.
  std::size_t payloads = 0;
  /// Wrong hash, does not decode, breaks a bound.
  std::size_t rejected = 0;
};

/// Receives and decodes on a thread of its own; the newest complete model can be taken at any time. A damaged payload
/// is counted, and the model stays what it was.
class SceneReceiver {
 public:
  [[nodiscard]] static Result<std::unique_ptr<SceneReceiver>> start(const LinkOptions& options);
  virtual ~SceneReceiver() = default;
  /// The newest complete model; null before the first one. Any thread.
  [[nodiscard]] virtual std::shared_ptr<const ReceivedModel> newest() const = 0;
  /// Any thread.
  [[nodiscard]] virtual ReceiveCounts counts() const = 0;
};

/// Decoded geometry that no manifest has named yet is kept up to this size (Submesh::geometry_bytes, and a texture's
/// JPEG); the oldest goes first.
inline constexpr std::size_t kMaxPendingBytes = 256u << 20;

/// The thread-free part: decodes payloads as they arrive and waits until all nodes of the newest manifest (highest
/// epoch, then revision) are there. A node whose geometry did not change shares it with the model before.
class ModelAssembler {
 public:
  explicit ModelAssembler(std::size_t max_pending_bytes = kMaxPendingBytes);
  ~ModelAssembler();
  /// A model when these samples completed a newer one than before.
  std::shared_ptr<const ReceivedModel> add(SceneSamples samples);
  [[nodiscard]] ReceiveCounts counts() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace meshloop
