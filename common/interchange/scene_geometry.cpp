#include "common/interchange/scene_geometry.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "common/interchange/color_space.h"
#include "common/interchange/solids.h"
#include "common/mesh/triangulate.h"

namespace meshloop {
namespace {

constexpr std::array<std::string_view, 4> kSolids{"Box", "Sphere", "Cylinder", "Cone"};
constexpr std::array<std::string_view, 3> kFaceSets{"IndexedFaceSet", "IndexedTriangleSet", "TriangleSet"};
constexpr std::array<std::string_view, 7> kNoSurfaces{"IndexedLineSet", "LineSet",     "PointSet", "Text",
                                                      "Polyline2D",     "Polypoint2D", "Arc2D"};
constexpr std::array<std::string_view, 8> kOtherGeometry{
    "ElevationGrid",         "Extrusion",        "IndexedQuadSet", "QuadSet",
    "IndexedTriangleFanSet", "TriangleStripSet", "TriangleFanSet", "IndexedTriangleStripSet"};

/// USE lets a short file name a scene of any size.
constexpr std::size_t kMaxVisits = 1'000'000;

template <class List>
bool contains(const List& list, std::string_view type) {
  return std::find(list.begin(), list.end(), type) != list.end();
}

Eigen::Vector3d vector_of(const WebNode& node, std::string_view field, const Eigen::Vector3d& otherwise) {
  const auto numbers = node.numbers(field);
  return numbers.size() >= 3 ? Eigen::Vector3d{numbers[0], numbers[1], numbers[2]} : otherwise;
}

Eigen::AngleAxisd rotation_of(const WebNode& node, std::string_view field) {
  const auto numbers = node.numbers(field);
  if (numbers.size() < 4) return Eigen::AngleAxisd::Identity();
  const Eigen::Vector3d axis{numbers[0], numbers[1], numbers[2]};
  return axis.norm() > 0 ? Eigen::AngleAxisd{numbers[3], axis.normalized()} : Eigen::AngleAxisd::Identity();
}

/// As 14772-1, 6.52: T C R SR S -SR -C.
Eigen::Affine3d transform_of(const WebNode& node) {
  const Eigen::Vector3d center = vector_of(node, "center", Eigen::Vector3d::Zero());
  const Eigen::AngleAxisd scale_frame = rotation_of(node, "scaleOrientation");
  return Eigen::Affine3d{Eigen::Translation3d{vector_of(node, "translation", Eigen::Vector3d::Zero()) + center} *
                         rotation_of(node, "rotation") * scale_frame *
                         Eigen::Scaling(vector_of(node, "scale", Eigen::Vector3d::Ones())) * scale_frame.inverse() *
                         Eigen::Translation3d{-center}};
}

std::vector<Rgb8> colors_in(const WebNode* color) {
  std::vector<Rgb8> colors;
  if (color == nullptr) return colors;
  const std::size_t stride = color->type == "ColorRGBA" ? 4 : 3;
  const auto numbers = color->numbers("color");
  for (std::size_t i = 0; i + stride <= numbers.size(); i += stride) {
    const auto channel = [&](std::size_t k) { return to_byte(static_cast<float>(numbers[i + k])); };
    colors.push_back({channel(0), channel(1), channel(2)});
  }
  return colors;
}

/// -1 between the faces, as in the file; also what is no index.
std::vector<std::int64_t> indices_in(const WebNode& node, std::string_view field) {
  std::vector<std::int64_t> indices;
  for (const double number : node.numbers(field)) {
    indices.push_back(number >= 0 && number < 4e9 ? static_cast<std::int64_t>(number) : -1);
  }
  return indices;
}

/// A face set's faces as corners in a row, each with a vertex of its own; vertices are joined later.
class FaceSet {
 public:
  explicit FaceSet(const WebNode& node) : node_{node} {}

  Result<Submesh> read() {
    if (auto ok = read_points(); !ok) return fail(ok.error());
    colors_ = colors_in(node_.node("color"));
    per_vertex_ = node_.flag("colorPerVertex", true);
    color_index_ = indices_in(node_, "colorIndex");
    if (auto ok = read_faces(); !ok) return fail(ok.error());
    if (!node_.flag("ccw", true)) {
      for (auto& triangle : mesh_.triangles) std::swap(triangle[1], triangle[2]);
    }
    return std::move(mesh_);
  }

 private:
  Status read_points() {
    const WebNode* const coord = node_.node("coord");
    if (coord == nullptr) return {};
    const auto numbers = coord->numbers("point");
    if (numbers.size() % 3 != 0) return fail("a Coordinate's numbers are no multiple of three");
    for (std::size_t i = 0; i < numbers.size(); i += 3) {
      points_.emplace_back(Eigen::Vector3d{numbers[i], numbers[i + 1], numbers[i + 2]}.cast<float>());
    }
    return {};
  }

  Status read_faces() {
    if (node_.type == "IndexedFaceSet") return read_polygons(indices_in(node_, "coordIndex"));
    std::vector<std::int64_t> index = indices_in(node_, "index");
    if (node_.type == "TriangleSet") {
      for (std::size_t i = 0; i < points_.size(); ++i) index.push_back(static_cast<std::int64_t>(i));
    }
    // As polygons with -1 after each triangle, which is how IndexedFaceSet writes them.
    std::vector<std::int64_t> faces;
    for (std::size_t i = 0; i + 3 <= index.size(); i += 3)
      faces.insert(faces.end(), {index[i], index[i + 1], index[i + 2], -1});
    color_index_.clear();
    return read_polygons(faces);
  }

  Status read_polygons(const std::vector<std::int64_t>& index) {
    std::size_t first = 0;
    std::size_t face = 0;
    for (std::size_t i = 0; i <= index.size(); ++i) {
      if (i < index.size() && index[i] >= 0) continue;
      if (i > first) {
        if (auto ok = add_face(index, first, i, face); !ok) return ok;
        ++face;
      }
      first = i + 1;
    }
    return {};
  }

  Status add_face(const std::vector<std::int64_t>& index, std::size_t first, std::size_t end, std::size_t face) {
    const auto start = static_cast<std::uint32_t>(mesh_.positions.size());
    std::vector<std::uint32_t> corners;
    for (std::size_t i = first; i < end; ++i) {
      const auto point = static_cast<std::size_t>(index[i]);
      if (point >= points_.size()) return fail("a face names a point that is not there");
      corners.push_back(start + static_cast<std::uint32_t>(corners.size()));
      mesh_.positions.push_back(points_[point]);
      if (colors_.empty()) continue;
      const auto color = color_of(point, i, face);
      if (!color) return fail("a face names a colour that is not there");
      mesh_.colors.push_back(*color);
    }
    if (corners.size() > kMostPolygonCorners)
      return fail(fmt::format("a face has more than {} corners", kMostPolygonCorners));
    append_polygon(corners, mesh_.positions, mesh_.triangles);
    return {};
  }

  /// By the rules of colorPerVertex and colorIndex.
  [[nodiscard]] std::optional<Rgb8> color_of(std::size_t point, std::size_t corner, std::size_t face) const {
    std::int64_t color = static_cast<std::int64_t>(per_vertex_ ? point : face);
    if (!color_index_.empty()) {
      const std::size_t at = per_vertex_ ? corner : face;
      color = at < color_index_.size() ? color_index_[at] : -1;
    }
    if (color < 0 || static_cast<std::size_t>(color) >= colors_.size()) return std::nullopt;
    return colors_[static_cast<std::size_t>(color)];
  }

  const WebNode& node_;
  std::vector<Eigen::Vector3f> points_;
  std::vector<Rgb8> colors_;
  bool per_vertex_ = true;
  std::vector<std::int64_t> color_index_;
  Submesh mesh_;
};

std::optional<Rgb8> material_color(const WebNode& shape) {
  const WebNode* const appearance = shape.node("appearance");
  const WebNode* const material = appearance == nullptr ? nullptr : appearance->node("material");
  if (material == nullptr) return std::nullopt;
  const auto color = material->numbers("diffuseColor");
  if (color.size() < 3) return std::nullopt;
  const auto channel = [&](std::size_t k) { return to_byte(static_cast<float>(color[k])); };
  return Rgb8{channel(0), channel(1), channel(2)};
}

class Collector {
 public:
  explicit Collector(std::size_t max_elements) : max_elements_{max_elements} {}

  /// `parent_name` names parts that have no DEF of their own.
  Status visit(const WebNode& node, const Eigen::Affine3d& T_scene_parent, const std::string& parent_name) {
    if (++visits_ > kMaxVisits) return fail("it uses its nodes more often than a million times");
    if (node.type == "Inline") return fail("it takes a part from another file (Inline); export it as one file");
    const std::string& name = node.name.empty() ? parent_name : node.name;
    if (node.type == "Shape") return add_shape(node, T_scene_parent, name);
    const Eigen::Affine3d T_scene_node =
        node.type == "Transform" ? T_scene_parent * transform_of(node) : T_scene_parent;
    for (const auto& child : children_of(node)) {
      if (auto ok = visit(*child, T_scene_node, name); !ok) return ok;
    }
    return {};
  }

  std::vector<ImportedPart> take() { return std::move(parts_); }

 private:
  static WebNodes children_of(const WebNode& node) {
    if (node.type == "Switch") {
      const auto& choices = node.nodes("choice").empty() ? node.nodes("children") : node.nodes("choice");
      const double which = node.number("whichChoice", -1);
      if (!(which >= 0 && which < static_cast<double>(choices.size()))) return {};
      return {choices[static_cast<std::size_t>(which)]};
    }
    if (node.type == "LOD") {
      const auto& levels = node.nodes("level").empty() ? node.nodes("children") : node.nodes("level");
      return levels.empty() ? WebNodes{} : WebNodes{levels.front()};
    }
    return node.nodes(node.type == "CADFace" && node.nodes("children").empty() ? "shape" : "children");
  }

  Status add_shape(const WebNode& shape, const Eigen::Affine3d& T_scene_shape, const std::string& name) {
    const WebNode* const geometry = shape.node("geometry");
    if (geometry == nullptr || contains(kNoSurfaces, geometry->type)) return {};
    auto mesh = contains(kFaceSets, geometry->type) ? FaceSet{*geometry}.read()
                : contains(kSolids, geometry->type)
                    ? tessellate_solid(*geometry)
                    : Result<Submesh>{fail(fmt::format(
                          "it has {} geometry, which is not read; export it as IndexedFaceSet", geometry->type))};
    if (!mesh) return fail(mesh.error());
    elements_ += mesh->triangles.size();
    if (const WebNode* const coord = geometry->node("coord")) elements_ += coord->numbers("point").size() / 3;
    if (elements_ > max_elements_) return fail("it has more triangles than are accepted");
    if (mesh->triangles.empty()) return {};
    if (const auto color = material_color(shape); color && !mesh->has_colors()) {
      mesh->colors.assign(mesh->positions.size(), *color);
    }
    for (auto& p : mesh->positions) p = (T_scene_shape * p.cast<double>()).cast<float>();
    if (T_scene_shape.linear().determinant() < 0) {
      for (auto& triangle : mesh->triangles) std::swap(triangle[1], triangle[2]);
    }
    parts_.push_back({name, std::move(*mesh)});
    return {};
  }

  std::size_t visits_ = 0;
  std::size_t max_elements_;
  std::size_t elements_ = 0;
  std::vector<ImportedPart> parts_;
};

}  // namespace

bool is_geometry(std::string_view type) {
  return contains(kSolids, type) || contains(kFaceSets, type) || contains(kNoSurfaces, type) ||
         contains(kOtherGeometry, type);
}

Result<std::vector<ImportedPart>> parts_of(const WebNodes& scene, const std::string& name, std::size_t max_elements) {
  Collector collector{max_elements};
  for (const auto& node : scene) {
    if (auto ok = collector.visit(*node, Eigen::Affine3d::Identity(), name); !ok) return fail(ok.error());
  }
  return collector.take();
}

}  // namespace meshloop
