#include <optional>
#include <set>

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/codec/mesh_codec.h"
#include "device/receive/decoded_payloads.h"
#include "device/receive/scene_receiver.h"

namespace meshloop {
namespace {

constexpr std::size_t kMaxUndecodable = 4096;

}  // namespace

struct ModelAssembler::State {
  explicit State(std::size_t max_pending_bytes) : decoded{max_pending_bytes} {}

  void take(Manifest newer);
  void take(const NodePayload& payload);
  std::shared_ptr<const ReceivedModel> complete();

  DecodedPayloads decoded;
  /// The newest one, and which payloads it names.
  std::optional<Manifest> manifest;
  std::set<Hash> named;
  /// Those of `named` that have not been decoded yet.
  std::set<Hash> missing;
  bool is_complete = false;
  /// Payloads that do not decode: they come again whenever the station offers what it has.
  std::set<Hash> undecodable;
  ReceiveCounts counts;
};

void ModelAssembler::State::take(Manifest newer) {
  const Age age{newer.epoch, newer.revision};
  if (manifest && age <= Age{manifest->epoch, manifest->revision}) return;
  manifest = std::move(newer);
  is_complete = false;
  named.clear();
  missing.clear();
  for (const auto& node : manifest->nodes) named.insert(node.payload_hash);
  decoded.keep(named, age);
  for (const auto& payload : named) {
    if (!decoded.find(payload)) missing.insert(payload);
  }
}

void ModelAssembler::State::take(const NodePayload& payload) {
  if (payload.bytes.size() > kMaxPayloadBytes || hash_of(payload.bytes) != payload.hash) {
    ++counts.rejected;
    return;
  }
  if (undecodable.contains(payload.hash)) {
    ++counts.rejected;
    return;
  }
  const Age age{payload.epoch, payload.revision};
  const bool is_named = named.contains(payload.hash);
  const bool is_stale = !is_named && manifest && age <= Age{manifest->epoch, manifest->revision};
  Decoded* const known = decoded.find(payload.hash);
  // A geometry may come back in a later revision: an older manifest that does not name it must not drop it then.
  if (known != nullptr) known->age = std::max(known->age, age);
  if (is_stale || known != nullptr) {
    ++counts.payloads;
    return;
  }
  const Stopwatch decoding;
  DecodeLimits limits;
  limits.max_bytes = kMaxPayloadBytes;
  auto submesh = decode(payload.bytes, limits);
  if (!submesh) {
    ++counts.rejected;
    if (undecodable.size() >= kMaxUndecodable) undecodable.clear();
    undecodable.insert(payload.hash);
    log_warning("node {} of revision {} does not decode: {}", payload.id, payload.revision, submesh.error().message);
    return;
  }
  ++counts.payloads;
  const Hash content = content_hash(*submesh);
  auto shared = std::make_shared<const Submesh>(std::move(*submesh));
  decoded.put(payload.hash, {std::move(shared), content, age, decoding.milliseconds()}, is_named);
  missing.erase(payload.hash);
}

std::shared_ptr<const ReceivedModel> ModelAssembler::State::complete() {
  if (!manifest || is_complete || !missing.empty()) return nullptr;
  auto model = std::make_shared<Model>();
  auto received = std::make_shared<ReceivedModel>();
  model->revision = manifest->revision;
  model->nodes.reserve(manifest->nodes.size());
  for (const auto& entry : manifest->nodes) {
    auto* part = decoded.find(entry.payload_hash);
    received->decode_ms += std::exchange(part->decode_ms, 0.0);
    model->nodes.push_back({entry.id, entry.name, entry.T_world_node, part->submesh, part->content});
  }
  received->model = std::move(model);
  received->epoch = manifest->epoch;
  received->accepted_ns = manifest->accepted_ns;
  received->complete_ns = wall_clock_ns();
  is_complete = true;
  return received;
}

ModelAssembler::ModelAssembler(std::size_t max_pending_bytes) : state_{std::make_unique<State>(max_pending_bytes)} {}
ModelAssembler::~ModelAssembler() = default;

std::shared_ptr<const ReceivedModel> ModelAssembler::add(SceneSamples samples) {
  if (samples.manifest) state_->take(std::move(*samples.manifest));
  for (auto& payload : samples.payloads) {
    state_->take(payload);
    payload.bytes = std::vector<std::byte>{};
  }
  return state_->complete();
}

ReceiveCounts ModelAssembler::counts() const {
  return state_->counts;
}

}  // namespace meshloop
