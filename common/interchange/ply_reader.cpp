#include "common/interchange/ply_reader.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "common/interchange/color_space.h"
#include "common/interchange/mapped_file.h"
#include "common/interchange/ply_header.h"
#include "common/interchange/ply_values.h"
#include "common/mesh/triangulate.h"

namespace meshloop {
namespace {

constexpr std::size_t kBetweenReports = 1 << 16;
constexpr auto kNoVertex = std::numeric_limits<std::uint32_t>::max();

/// Where a vertex property goes: 0 to 2 position, 3 to 5 colour.
std::optional<std::size_t> slot_of(std::string_view name) {
  constexpr std::array<std::string_view, 6> kNames{"x", "y", "z", "red", "green", "blue"};
  constexpr std::array<std::string_view, 6> kOtherNames{"", "", "", "diffuse_red", "diffuse_green", "diffuse_blue"};
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (name == kNames[i] || name == kOtherNames[i]) return i;
  }
  return std::nullopt;
}

/// What a colour value is multiplied with to be a byte.
double byte_scale(PlyType type) {
  switch (type) {
    case PlyType::float32:
    case PlyType::float64:
      return 255;
    case PlyType::uint16:
      return 255.0 / 65535;
    default:
      return 1;
  }
}

std::uint8_t to_color_byte(double value) {
  return to_byte(static_cast<float>(value / 255));
}

struct VertexLayout {
  std::vector<std::optional<std::size_t>> slots;
  std::array<double, 6> scale{1, 1, 1, 1, 1, 1};
  bool has_position = false;
  bool has_color = false;
};

VertexLayout layout_of(const PlyElement& element) {
  VertexLayout layout;
  std::array<bool, 6> found{};
  for (const auto& property : element.properties) {
    const auto slot = property.is_list ? std::nullopt : slot_of(property.name);
    layout.slots.push_back(slot);
    if (!slot) continue;
    found[*slot] = true;
    if (*slot >= 3) layout.scale[*slot] = byte_scale(property.type);
  }
  layout.has_position = found[0] && found[1] && found[2];
  layout.has_color = found[3] && found[4] && found[5];
  return layout;
}

std::uint32_t to_index(double value) {
  return value >= 0 && value < kNoVertex ? static_cast<std::uint32_t>(value) : kNoVertex;
}

template <class Values>
class Body {
 public:
  Body(std::string_view content, const Progress& progress) : values_{content}, progress_{progress} {}

  Result<Submesh> read(const PlyHeader& header) {
    for (const auto& element : header.elements) {
      if (auto ok = check_count(element); !ok) return fail(ok.error());
      if (auto ok = read_element(element); !ok) return fail(ok.error());
      if (!values_.good())
        return fail(fmt::format("it ends, or holds no number, within its element '{}'", element.name));
    }
    return std::move(mesh_);
  }

 private:
  Status read_element(const PlyElement& element) {
    if (element.name == "vertex") return read_vertices(element);
    if (element.name == "face" || element.name == "tristrips") return read_faces(element);
    for (std::size_t i = 0; i < element.count && values_.good(); ++i) {
      for (const auto& property : element.properties) skip(property);
    }
    return {};
  }

  /// A claim that the file is too short for must not cost memory.
  Status check_count(const PlyElement& element) const {
    std::size_t bytes = 0;
    for (const auto& p : element.properties) bytes += size_of(p.is_list ? p.count_type : p.type);
    const bool fits = element.count == 0 || (bytes > 0 && element.count <= values_.most_left(PlyType::uint8));
    return fits
               ? Status{}
               : fail(fmt::format("it is too short for the {} times '{}' that it claims", element.count, element.name));
  }

  Status read_vertices(const PlyElement& element) {
    const VertexLayout layout = layout_of(element);
    if (!layout.has_position) return fail("its vertices have no x, y and z");
    mesh_.positions.reserve(element.count);
    if (layout.has_color) mesh_.colors.reserve(element.count);
    for (std::size_t i = 0; i < element.count && values_.good(); ++i) {
      report(i);
      std::array<double, 6> value{};
      for (std::size_t k = 0; k < layout.slots.size(); ++k) {
        if (layout.slots[k]) {
          value[*layout.slots[k]] = values_.next(element.properties[k].type);
        } else {
          skip(element.properties[k]);
        }
      }
      mesh_.positions.emplace_back(Eigen::Vector3d{value[0], value[1], value[2]}.cast<float>());
      if (!layout.has_color) continue;
      const auto channel = [&](std::size_t slot) { return to_color_byte(value[slot] * layout.scale[slot]); };
      mesh_.colors.push_back({channel(3), channel(4), channel(5)});
    }
    return {};
  }

  Status read_faces(const PlyElement& element) {
    const bool strips = element.name == "tristrips";
    if (!strips) mesh_.triangles.reserve(std::min(element.count, kMaxTriangles));
    for (std::size_t i = 0; i < element.count && values_.good(); ++i) {
      report(i);
      for (const auto& property : element.properties) {
        const bool indices = property.is_list && (property.name == "vertex_indices" || property.name == "vertex_index");
        if (!indices) {
          skip(property);
        } else if (auto ok = read_list(property, strips); !ok) {
          return ok;
        }
      }
    }
    return {};
  }

  Status read_list(const PlyProperty& property, bool strips) {
    const double count = values_.next(property.count_type);
    const auto most =
        strips ? values_.most_left(property.type) : std::min(kMostPolygonCorners, values_.most_left(property.type));
    if (!(count >= 0 && count <= static_cast<double>(most))) return fail("a list in it is longer than can be");
    corners_.clear();
    for (auto left = static_cast<std::size_t>(count); left > 0 && values_.good(); --left) {
      corners_.push_back(to_index(values_.next(property.type)));
    }
    if (!values_.good()) return {};
    if (strips) return append_strips();
    // Points and edges are no surface.
    if (corners_.size() < 3 || append_polygon(corners_, mesh_.positions, mesh_.triangles)) return {};
    return fail("a triangle names a vertex that is not there");
  }

  Status append_strips() {
    std::size_t length = 0;
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      length = corners_[i] == kNoVertex ? 0 : length + 1;
      if (length < 3) continue;
      const bool odd = length % 2 == 0;
      const std::array<std::uint32_t, 3> triangle{corners_[odd ? i - 1 : i - 2], corners_[odd ? i - 2 : i - 1],
                                                  corners_[i]};
      if (!append_polygon(triangle, mesh_.positions, mesh_.triangles)) {
        return fail("a triangle names a vertex that is not there");
      }
    }
    return {};
  }

  void skip(const PlyProperty& property) {
    const double count = property.is_list ? values_.next(property.count_type) : 1;
    for (double i = 0; i < count && values_.good(); ++i) values_.next(property.type);
  }

  void report(std::size_t item) const {
    if (item % kBetweenReports == 0) progress_(values_.share_done());
  }

  Values values_;
  const Progress& progress_;
  Submesh mesh_;
  std::vector<std::uint32_t> corners_;
};

}  // namespace

Result<Submesh> parse_ply(std::string_view content, const Progress& progress) {
  const auto header = parse_ply_header(content);
  if (!header) return fail(header.error());
  const std::string_view body = content.substr(header->size);
  switch (header->encoding) {
    case PlyHeader::Encoding::little_endian:
      return Body<PlyByteValues<std::endian::little>>{body, progress}.read(*header);
    case PlyHeader::Encoding::big_endian:
      return Body<PlyByteValues<std::endian::big>>{body, progress}.read(*header);
    case PlyHeader::Encoding::ascii:
      break;
  }
  return Body<PlyTextValues>{body, progress}.read(*header);
}

Result<ReadParts> read_ply(const std::filesystem::path& file, const Progress& progress) {
  const auto content = MappedFile::open(file);
  if (!content) return fail(content.error());
  auto mesh = parse_ply(content->text(), progress);
  if (!mesh) return fail(mesh.error());
  ReadParts read;
  if (!mesh->triangles.empty()) read.parts.push_back({file.stem().string(), std::move(*mesh)});
  return read;
}

}  // namespace meshloop
