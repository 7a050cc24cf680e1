#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>

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
  std::size_t payloads = 0;
  /// Wrong hash, does not decode, breaks a bound.
  std::size_t rejected = 0;
};

/// Receives and decodes on a thread of its own; the newest complete model can be taken at any time. A damaged payload is
/// counted, and the model stays what it was.
class SceneReceiver {
 public:
  static Result<std::unique_ptr<SceneReceiver>> start(const LinkOptions& options);
  virtual ~SceneReceiver() = default;
  /// The newest complete model; null before the first one. Any thread.
  [[nodiscard]] virtual std::shared_ptr<const ReceivedModel> newest() const = 0;
  [[nodiscard]] virtual ReceiveCounts counts() const = 0;
};

/// The thread-free part: collects samples until a manifest's nodes are all there.
class ModelAssembler {
 public:
  ModelAssembler();
  ~ModelAssembler();
  /// A model when these samples completed a newer one than before.
  std::shared_ptr<const ReceivedModel> add(SceneSamples samples);
  [[nodiscard]] ReceiveCounts counts() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace meshloop
