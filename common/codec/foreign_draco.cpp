#include "common/codec/foreign_draco.h"

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>
#include <fmt/format.h>

#include <algorithm>
#include <exception>

namespace meshloop {
namespace {

/// What an integer attribute's values are divided by to lie between 0 and 1; 1 for floats, and where Draco divides.
float divisor_of(const draco::PointAttribute& attribute) {
  if (attribute.normalized()) return 1;
  switch (attribute.data_type()) {
    case draco::DT_UINT8:
      return 255;
    case draco::DT_UINT16:
      return 65535;
    default:
      return 1;
  }
}

template <int components, class Use>
bool for_each_value(const draco::PointAttribute& attribute, std::uint32_t points, Use use) {
  std::array<float, components> value{};
  for (std::uint32_t i = 0; i < points; ++i) {
    const auto index = attribute.mapped_index(draco::PointIndex(i));
    if (index.value() >= attribute.size()) return false;
    if (!attribute.ConvertValue<float, components>(index, value.data())) return false;
    use(value);
  }
  return true;
}

Status copy_colors(const draco::PointAttribute* attribute, std::uint32_t points, ForeignMesh& mesh) {
  if (attribute == nullptr) return fail("the Draco payload lacks the colours that the file names");
  const float divisor = divisor_of(*attribute);
  const bool has_opacity = attribute->num_components() >= 4;
  mesh.colors.reserve(points);
  const bool done = for_each_value<4>(*attribute, points, [&](std::array<float, 4> value) {
    for (float& channel : value) channel /= divisor;
    if (!has_opacity) value[3] = 1;
    mesh.colors.push_back(value);
  });
  return done ? Status{} : fail("the Draco payload's colours cannot be read");
}

Result<ForeignMesh> to_foreign(const draco::Mesh& decoded, const ForeignAttributes& attributes) {
  ForeignMesh mesh;
  const std::uint32_t points = decoded.num_points();
  const auto* position = decoded.GetAttributeByUniqueId(attributes.position);
  if (position == nullptr || position->num_components() != 3) {
    return fail("the Draco payload lacks the positions that the file names");
  }
  mesh.positions.reserve(points);
  if (!for_each_value<3>(*position, points, [&](const auto& p) { mesh.positions.emplace_back(p[0], p[1], p[2]); })) {
    return fail("the Draco payload's positions cannot be read");
  }
  if (attributes.color) {
    if (auto ok = copy_colors(decoded.GetAttributeByUniqueId(*attributes.color), points, mesh); !ok) {
      return fail(ok.error());
    }
  }
  mesh.triangles.reserve(decoded.num_faces());
  for (std::uint32_t t = 0; t < decoded.num_faces(); ++t) {
    const auto& face = decoded.face(draco::FaceIndex(t));
    const Triangle triangle{face[0].value(), face[1].value(), face[2].value()};
    if (std::max({triangle[0], triangle[1], triangle[2]}) >= points) {
      return fail("a triangle of the Draco payload names a vertex that is not there");
    }
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

}  // namespace

Result<ForeignMesh> decode_foreign(std::span<const std::byte> bytes, const ForeignAttributes& attributes,
                                   const DecodeLimits& limits) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  try {
    draco::Decoder decoder;
    auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok()) {
      return fail(fmt::format("a Draco payload is damaged ({})", decoded.status().error_msg_string()));
    }
    const draco::Mesh& mesh = *decoded.value();
    if (mesh.num_points() > limits.max_vertices || mesh.num_faces() > limits.max_triangles) {
      return fail(fmt::format("a Draco payload has {} vertices and {} triangles; at most {} and {} are accepted",
                              mesh.num_points(), mesh.num_faces(), limits.max_vertices, limits.max_triangles));
    }
    return to_foreign(mesh, attributes);
  } catch (const std::exception& error) {
    return fail(fmt::format("a Draco payload is damaged ({})", error.what()));
  }
}

}  // namespace meshloop
