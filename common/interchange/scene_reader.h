#pragma once
// Files through assimp.
#include <cstddef>
#include <filesystem>
#include <span>

#include "common/base/result.h"
#include "common/interchange/gltf_texture.h"
#include "common/interchange/read_file.h"

namespace meshloop {

/// A FormatReader for OBJ, OFF and text STL: one part for each use of a mesh in the file's scene graph, transforms
/// applied.
[[nodiscard]] Result<ReadParts> read_with_assimp(const std::filesystem::path& file, const Progress& progress);

/// The same for a GLB in memory; `file` gives its name. Meshes with a material that is in `textures` get its texture.
[[nodiscard]] Result<ReadParts> read_glb_with_assimp(std::span<const std::byte> glb, const std::filesystem::path& file,
                                                     const GltfTextures& textures, const Progress& progress);

}  // namespace meshloop
