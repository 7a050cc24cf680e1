#include "server/publish/encode_nodes.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "common/codec/mesh_codec.h"
#include "common/transport/scene_link.h"

namespace meshloop {
namespace {

Result<EncodedNode> encode_node(const Node& node) {
  auto bytes = encode(*node.submesh);
  if (!bytes) return fail(fmt::format("encoding node {} ('{}')", node.id, node.name), bytes.error());
  if (bytes->size() > kMaxPayloadBytes) {
    return fail(
        fmt::format("node {} ('{}', {} triangles) has {} encoded bytes, but only {} can be sent in one piece: split "
                    "it into smaller nodes",
                    node.id, node.name, node.submesh->triangles.size(), bytes->size(), kMaxPayloadBytes));
  }
  const Hash hash = hash_of(*bytes);
  return EncodedNode{std::move(*bytes), hash};
}

}  // namespace

Result<std::vector<EncodedNode>> encode_nodes(std::span<const Node* const> nodes, unsigned threads) {
  std::vector<Result<EncodedNode>> results(nodes.size());
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < nodes.size(); i = next++) results[i] = encode_node(*nodes[i]);
  };
  {
    std::vector<std::jthread> helpers;
    for (std::size_t i = 1; i < std::min<std::size_t>(threads, nodes.size()); ++i) helpers.emplace_back(work);
    work();
  }
  std::vector<EncodedNode> encoded;
  encoded.reserve(nodes.size());
  for (auto& result : results) {
    if (!result) return fail(result.error());
    encoded.push_back(std::move(*result));
  }
  return encoded;
}

}  // namespace meshloop
