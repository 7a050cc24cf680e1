#pragma once
// Models as the bytes of files. Pure functions: writing them is model_file.h's business.
#include <cstddef>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/model.h"

namespace meshloop {

/// Colour of vertices without one, in formats where either all vertices have a colour or none.
inline constexpr Rgb8 kNoColor{200, 200, 200};

/// Binary glTF 2.0: one node a node, with its name and transform (column-major matrix, all digits); positions as
/// float32, colours as linear light in normalised 16-bit RGBA (sRGB bytes come back exactly), indices as uint32. A
/// texture is its JPEG, byte for byte, with coordinates at vertices (texture_coordinates.h), and its projection in the
/// material's extras (gltf_texture.h).
[[nodiscard]] Result<std::vector<std::byte>> to_glb(const Model& model);
/// Binary little-endian PLY in world coordinates, all nodes in one mesh; red, green, blue when any node has colours;
/// of a texture what lies at the vertices.
[[nodiscard]] Result<std::vector<std::byte>> to_ply(const Model& model);
/// Wavefront OBJ in world coordinates, an object a node, colours (where a node has them) as sRGB after the position;
/// of a texture what lies at the vertices.
[[nodiscard]] Result<std::vector<std::byte>> to_obj(const Model& model);

}  // namespace meshloop
