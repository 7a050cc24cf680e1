#pragma once
#include "common/base/result.h"
#include "common/interchange/scene_nodes.h"
#include "common/mesh/submesh.h"

namespace meshloop {

/// The triangles of a Box, Sphere, Cylinder or Cone of X3D or VRML 97 in its own frame (y up), closed and seen from
/// outside. Curved surfaces are tessellated as kSolidDeflection says. Refuses sizes that are not positive.
[[nodiscard]] Result<Submesh> tessellate_solid(const WebNode& node);

}  // namespace meshloop
