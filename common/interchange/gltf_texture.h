#pragma once
// Projections of our own textures in glTF: whoever knows them needs no coordinates at vertices.
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "common/interchange/gltf_container.h"
#include "common/mesh/texture.h"

namespace meshloop {

/// In a material's `extras`: ProjectedTexture::projection, column by column, from the mesh's own coordinates.
inline constexpr const char* kProjectionKey = "meshloop_projection";

/// By the materials' names: assimp numbers materials anew, in the order in which meshes use them.
using GltfTextures = std::map<std::string, std::shared_ptr<const ProjectedTexture>, std::less<>>;

/// The textures of materials that have a projection. Their pictures are JPEGs in the GLB's own chunk; none for a
/// document that names no projection. Refuses projections and pictures that are not what they should be, and such
/// materials that have no name of their own.
[[nodiscard]] Result<GltfTextures> read_projected_textures(const GltfChunks& chunks);

}  // namespace meshloop
