#include "common/transport/wire.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

namespace meshloop {
namespace {

constexpr double kUnitTolerance = 1e-6;
// A scene's extent in every direction; the same bound as a submesh's (see mesh/submesh.h).
constexpr double kFarthest_m = 10e3;

template <std::size_t N>
void put_text(const std::string& text, char (&field)[N]) {
  std::memset(field, 0, N);
  std::memcpy(field, text.data(), std::min(text.size(), N - 1));
}

// The field's text up to its end mark; all of it where a peer left none.
template <std::size_t N>
std::string_view text_of(const char (&field)[N]) {
  return {field, strnlen(field, N)};
}

template <std::size_t N>
Hash hash_from(const std::uint8_t (&field)[N]) {
  Hash hash{};
  static_assert(sizeof hash == N);
  std::memcpy(hash.data(), field, N);
  return hash;
}

Status check_origin(std::string_view sample_scene, std::uint32_t version, const std::string& scene) {
  if (sample_scene != scene) return fail(fmt::format("a sample of the scene '{}'", sample_scene));
  if (version != meshloop_wire_kSchemaVersion) {
    return fail(fmt::format("the station speaks schema version {}, this program {}: update the older one", version,
                            meshloop_wire_kSchemaVersion));
  }
  return {};
}

Status check_entry(const ManifestEntry& entry) {
  if (entry.id == 0) return fail("a manifest names a node 0; ids start at 1");
  if (entry.name.size() > kMaxNameBytes || entry.name.find('\0') != std::string::npos) {
    return fail(fmt::format("the name of node {} is not a text of at most {} bytes", entry.id, kMaxNameBytes));
  }
  if (!is_rigid(entry.T_world_node)) return fail(fmt::format("the transform of node {} is not rigid", entry.id));
  if (entry.T_world_node.translation().cwiseAbs().maxCoeff() > kFarthest_m) {
    return fail(fmt::format("node {} lies farther than {} km from the origin", entry.id, kFarthest_m / 1000));
  }
  return {};
}

meshloop_wire_NodeEntry entry_to_wire(const ManifestEntry& entry) {
  meshloop_wire_NodeEntry wire{};
  wire.node = entry.id;
  put_text(entry.name, wire.name);
  const Eigen::Quaterniond rotation(entry.T_world_node.linear());
  Eigen::Map<Eigen::Vector3d>{wire.translation_m} = entry.T_world_node.translation();
  Eigen::Map<Eigen::Vector4d>{wire.rotation_xyzw} = rotation.normalized().coeffs();
  std::memcpy(wire.payload_hash, entry.payload_hash.data(), sizeof wire.payload_hash);
  return wire;
}

Result<ManifestEntry> entry_from_wire(const meshloop_wire_NodeEntry& wire) {
  const Eigen::Map<const Eigen::Vector3d> translation{wire.translation_m};
  const Eigen::Quaterniond rotation{wire.rotation_xyzw[3], wire.rotation_xyzw[0], wire.rotation_xyzw[1],
                                    wire.rotation_xyzw[2]};
  // Written so that NaN fails too.
  if (!(translation.allFinite() && std::abs(rotation.norm() - 1.0) <= kUnitTolerance)) {
    return fail(fmt::format("the transform of node {} is not rigid", wire.node));
  }
  ManifestEntry entry{wire.node, std::string{text_of(wire.name)}, make_pose(translation, rotation),
                      hash_from(wire.payload_hash)};
  if (auto ok = check_entry(entry); !ok) return fail(ok.error());
  return entry;
}

}  // namespace

Status check_scene_name(const std::string& scene) {
  const auto forbidden = [](char c) {
    const auto code = static_cast<unsigned char>(c);
    return code < 0x20 || code == 0x7f || c == '*' || c == '?';
  };
  if (!scene.empty() && scene.size() <= kMaxNameBytes && std::none_of(scene.begin(), scene.end(), forbidden)) return {};
  return fail(
      fmt::format("'{}' cannot name a scene on the network: use 1 to {} bytes without control characters, * and ?",
                  scene.substr(0, kMaxNameBytes), kMaxNameBytes),
      ErrorKind::usage);
}

Result<meshloop_wire_MeshNode> to_wire(const NodePayload& payload, const std::string& scene) {
  if (payload.id == 0) return fail("a payload names a node 0; ids start at 1");
  if (payload.bytes.empty() || payload.bytes.size() > kMaxPayloadBytes) {
    return fail(fmt::format("node {} has {} encoded bytes, but 1 to {} can be sent: split the node", payload.id,
                            payload.bytes.size(), kMaxPayloadBytes));
  }
  meshloop_wire_MeshNode sample{};
  put_text(scene, sample.scene);
  sample.node = payload.id;
  sample.schema_version = meshloop_wire_kSchemaVersion;
  sample.epoch = payload.epoch;
  sample.revision = payload.revision;
  std::memcpy(sample.payload_hash, payload.hash.data(), sizeof sample.payload_hash);
  const auto size = static_cast<std::uint32_t>(payload.bytes.size());
  // DDS only reads from here while it writes the sample; its structs know no const.
  auto* bytes = reinterpret_cast<std::uint8_t*>(const_cast<std::byte*>(payload.bytes.data()));
  sample.payload = {size, size, bytes, false};
  return sample;
}

Result<WireManifest> to_wire(const Manifest& manifest, const std::string& scene) {
  if (manifest.nodes.size() > kMaxManifestNodes) {
    return fail(fmt::format("the scene has {} nodes, but a manifest can name {}: join nodes", manifest.nodes.size(),
                            kMaxManifestNodes));
  }
  WireManifest wire;
  wire.entries.reserve(manifest.nodes.size());
  for (const auto& entry : manifest.nodes) {
    if (auto ok = check_entry(entry); !ok) return fail(ok.error());
    wire.entries.push_back(entry_to_wire(entry));
  }
  put_text(scene, wire.sample.scene);
  wire.sample.schema_version = meshloop_wire_kSchemaVersion;
  wire.sample.epoch = manifest.epoch;
  wire.sample.revision = manifest.revision;
  wire.sample.accepted_ns = manifest.accepted_ns;
  const auto count = static_cast<std::uint32_t>(wire.entries.size());
  wire.sample.nodes = {count, count, wire.entries.data(), false};
  return wire;
}

Result<NodePayload> from_wire(const meshloop_wire_MeshNode& sample, const std::string& scene) {
  if (auto ok = check_origin(text_of(sample.scene), sample.schema_version, scene); !ok) return fail(ok.error());
  if (sample.node == 0) return fail("a payload names a node 0");
  if (sample.payload._length == 0 || sample.payload._length > kMaxPayloadBytes) {
    return fail(fmt::format("the payload of node {} has {} bytes", sample.node, sample.payload._length));
  }
  const std::span bytes{reinterpret_cast<const std::byte*>(sample.payload._buffer), sample.payload._length};
  NodePayload payload{sample.node, sample.epoch, sample.revision, hash_from(sample.payload_hash), {}};
  if (hash_of(bytes) != payload.hash) {
    return fail(fmt::format("the payload of node {} does not have its hash", sample.node));
  }
  payload.bytes.assign(bytes.begin(), bytes.end());
  return payload;
}

Result<Manifest> from_wire(const meshloop_wire_Manifest& sample, const std::string& scene) {
  if (auto ok = check_origin(text_of(sample.scene), sample.schema_version, scene); !ok) return fail(ok.error());
  if (sample.nodes._length > kMaxManifestNodes) return fail("a manifest names too many nodes");
  Manifest manifest{sample.epoch, sample.revision, sample.accepted_ns, {}};
  manifest.nodes.reserve(sample.nodes._length);
  for (const auto& wire : std::span{sample.nodes._buffer, sample.nodes._length}) {
    auto entry = entry_from_wire(wire);
    if (!entry) return fail(entry.error());
    manifest.nodes.push_back(std::move(*entry));
  }
  const auto by_id = [](const ManifestEntry& a, const ManifestEntry& b) { return a.id < b.id; };
  const auto same_id = [](const ManifestEntry& a, const ManifestEntry& b) { return a.id == b.id; };
  std::sort(manifest.nodes.begin(), manifest.nodes.end(), by_id);
  const auto twice = std::adjacent_find(manifest.nodes.begin(), manifest.nodes.end(), same_id);
  if (twice != manifest.nodes.end()) return fail(fmt::format("a manifest names node {} twice", twice->id));
  return manifest;
}

}  // namespace meshloop
