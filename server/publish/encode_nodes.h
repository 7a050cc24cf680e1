#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/model.h"

namespace meshloop {

struct EncodedNode {
  std::vector<std::byte> bytes;
  /// Of the bytes.
  Hash hash{};
};

/// Encodes the nodes, in their order, on up to `threads` threads. Fails when one cannot be encoded or is larger than a
/// sample may be; the sentence names the node.
[[nodiscard]] Result<std::vector<EncodedNode>> encode_nodes(std::span<const Node* const> nodes, unsigned threads);

}  // namespace meshloop
