// A device's assembler against whatever a station could send: manifests and payloads made of the fuzzer's bytes.
// Rooms: device/receive common/codec
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "device/receive/scene_receiver.h"

namespace {

using meshloop::Hash;
using meshloop::Manifest;
using meshloop::NodePayload;
using meshloop::SceneSamples;

// Takes values off the front of the input; zeros when it is used up.
class Input {
 public:
  explicit Input(std::span<const std::byte> bytes) : rest_{bytes} {}

  template <class T>
  T value() {
    T read{};
    const auto bytes = take(sizeof(T));
    std::memcpy(&read, bytes.data(), bytes.size());
    return read;
  }
  std::span<const std::byte> take(std::size_t size) {
    const auto taken = rest_.first(std::min(size, rest_.size()));
    rest_ = rest_.subspan(taken.size());
    return taken;
  }
  [[nodiscard]] bool is_empty() const { return rest_.empty(); }

 private:
  std::span<const std::byte> rest_;
};

NodePayload payload_from(Input& input) {
  NodePayload payload;
  payload.id = input.value<std::uint8_t>();
  payload.epoch = input.value<std::uint8_t>() % 4u;
  payload.revision = input.value<std::uint8_t>() % 8u;
  const bool has_its_hash = input.value<std::uint8_t>() != 0;
  const auto bytes = input.take(input.value<std::uint16_t>());
  payload.bytes.assign(bytes.begin(), bytes.end());
  if (has_its_hash) payload.hash = meshloop::hash_of(payload.bytes);
  return payload;
}

Manifest manifest_from(Input& input, std::span<const NodePayload> payloads) {
  Manifest manifest;
  manifest.epoch = input.value<std::uint8_t>() % 4u;
  manifest.revision = input.value<std::uint8_t>() % 8u;
  const std::size_t count = input.value<std::uint8_t>() % 16u;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t chosen = input.value<std::uint8_t>();
    const Hash hash = chosen < payloads.size() ? payloads[chosen].hash : Hash{};
    manifest.nodes.push_back({input.value<std::uint8_t>(), "", meshloop::Pose::Identity(), hash});
  }
  return manifest;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Input input{std::as_bytes(std::span{data, size})};
  meshloop::ModelAssembler assembler{1u << 20};
  while (!input.is_empty()) {
    SceneSamples samples;
    const std::size_t count = input.value<std::uint8_t>() % 4u;
    for (std::size_t i = 0; i < count; ++i) samples.payloads.push_back(payload_from(input));
    if (input.value<std::uint8_t>() % 2u != 0) samples.manifest = manifest_from(input, samples.payloads);
    const auto received = assembler.add(std::move(samples));
    if (!received) continue;
    for (const auto& node : received->model->nodes) {
      if (!node.submesh || !validate(*node.submesh)) __builtin_trap();
    }
  }
  return 0;
}
