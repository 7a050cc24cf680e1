#pragma once
// Draco meshes of other programs, as glTF's KHR_draco_mesh_compression embeds them.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/codec/mesh_codec.h"

namespace meshloop {

struct ForeignMesh {
  std::vector<Eigen::Vector3f> positions;
  /// Red, green, blue, opacity from 0 to 1, as they are stored; one a position, or none.
  std::vector<std::array<float, 4>> colors;
  std::vector<Triangle> triangles;
};

/// Which of the payload's attributes to take, by their unique ids.
struct ForeignAttributes {
  std::uint32_t position = 0;
  std::optional<std::uint32_t> color;
};

/// Decodes whatever Draco can. Call in a process whose memory and time are limited: unlike `decode`, this lets Draco
/// see every kind of attribute. Refuses indices out of range and counts above the limits (the bytes are not limited).
[[nodiscard]] Result<ForeignMesh> decode_foreign(std::span<const std::byte> bytes, const ForeignAttributes& attributes,
                                                 const DecodeLimits& limits);

}  // namespace meshloop
