#pragma once
// Textures in the tables `texture` and `jpeg`: a picture once, however many submeshes are left of the one it was for.
#include <memory>

#include "common/base/hash.h"
#include "common/mesh/texture.h"
#include "server/store/sqlite.h"

namespace meshloop {

/// The texture of a geometry; null when it has none. The scene must have the tables (has_textures). Whether it is what
/// was stored is told by the geometry's hash, which covers it.
[[nodiscard]] Result<std::shared_ptr<const ProjectedTexture>> read_texture(Database& database, const Hash& geometry);

/// In a transaction, after the geometry's row.
[[nodiscard]] Status append_texture(Database& database, const Hash& geometry, const ProjectedTexture& texture);

}  // namespace meshloop
