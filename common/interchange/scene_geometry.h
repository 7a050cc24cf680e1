#pragma once
// The surfaces of X3D and VRML 97 scenes.
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/interchange/model_file.h"
#include "common/interchange/scene_nodes.h"

namespace meshloop {

/// A surface that curves is made of flat triangles that lie at most this far inside it (in the node's own units, before
/// its parents' scale), unless that takes more than 512 segments a turn.
inline constexpr double kSolidDeflection = 0.0002;

/// True for nodes that stand in a Shape's `geometry`.
[[nodiscard]] bool is_geometry(std::string_view type);

/// One part for each Shape with a surface: IndexedFaceSet, IndexedTriangleSet, TriangleSet, Box, Sphere, Cylinder,
/// Cone. Grouping nodes' transforms are applied; a Switch gives its chosen child, a LOD its finest. Vertex and face
/// colours, else the material's diffuse colour. Lines, points and text have no surface and are passed over; any other
/// geometry is refused, since a model that lacks a part shows it as a change. Refuses scenes of more triangles and
/// points than `max_elements`, counted as often as they are used.
[[nodiscard]] Result<std::vector<ImportedPart>> parts_of(const WebNodes& scene, const std::string& name,
                                                         std::size_t max_elements = kMaxTriangles);

}  // namespace meshloop
