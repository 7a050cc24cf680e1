#include "common/codec/mesh_codec.h"

#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/mesh/mesh.h>
#include <fmt/format.h>

#include <array>
#include <exception>

#include "common/codec/color_transform.h"
#include "common/codec/draco_header.h"
#include "common/codec/texture_frame.h"
#include "common/image/jpeg_codec.h"
#include "common/mesh/lattice.h"

namespace meshloop {
namespace {

using draco::GeometryAttribute;

bool is_three_of(const draco::PointAttribute& attribute, GeometryAttribute::Type kind) {
  return attribute.attribute_type() == kind && attribute.num_components() == 3;
}

/// Positions, and perhaps colours: all that encode() writes.
bool has_expected_attributes(const draco::PointCloud& cloud) {
  const int count = cloud.num_attributes();
  if (count != 1 && count != 2) return false;
  const auto& position = *cloud.attribute(0);
  if (!is_three_of(position, GeometryAttribute::POSITION) || position.data_type() != draco::DT_FLOAT32) return false;
  if (count == 1) return true;
  const auto& color = *cloud.attribute(1);
  return is_three_of(color, GeometryAttribute::COLOR) && color_step(color.data_type()) != 0;
}

/// Stops after the attributes' descriptions when they are not the expected ones, so that no value of another kind is
/// decoded: texture coordinates and normals are where decoding can become slow or crash.
class ExpectedMeshDecoder : public draco::MeshEdgebreakerDecoder {
 protected:
  bool CreateAttributesDecoder(int32_t id) override {
    return id < 2 && draco::MeshEdgebreakerDecoder::CreateAttributesDecoder(id);
  }
  bool DecodeAllAttributes() override {
    return has_expected_attributes(*point_cloud()) && draco::MeshEdgebreakerDecoder::DecodeAllAttributes();
  }
};

template <class T>
bool copy_values(const draco::PointAttribute& attribute, std::uint32_t points, std::vector<T>& values) {
  const auto stride = static_cast<std::size_t>(attribute.byte_stride());
  if (stride != sizeof(T) || attribute.buffer() == nullptr) return false;
  if (attribute.buffer()->data_size() < attribute.size() * stride) return false;
  values.resize(points);
  for (std::uint32_t i = 0; i < points; ++i) {
    const auto index = attribute.mapped_index(draco::PointIndex(i));
    if (index.value() >= attribute.size()) return false;
    attribute.GetValue(index, values[i].data());
  }
  return true;
}

Result<Submesh> to_submesh(const draco::Mesh& mesh) {
  Submesh submesh;
  std::vector<CodedColor> coded;
  const bool has_colors = mesh.num_attributes() == 2;
  if (!copy_values(*mesh.attribute(0), mesh.num_points(), submesh.positions) ||
      (has_colors && !copy_values(*mesh.attribute(1), mesh.num_points(), coded))) {
    return fail("the Draco payload has fewer values than vertices");
  }
  submesh.colors.reserve(coded.size());
  const int step = has_colors ? color_step(mesh.attribute(1)->data_type()) : 1;
  for (const auto& color : coded) submesh.colors.push_back(from_coded(color, step));
  submesh.triangles.reserve(mesh.num_faces());
  for (std::uint32_t t = 0; t < mesh.num_faces(); ++t) {
    const auto& face = mesh.face(draco::FaceIndex(t));
    submesh.triangles.push_back({face[0].value(), face[1].value(), face[2].value()});
  }
  return submesh;
}

Status check_claims(std::span<const std::byte> bytes, const DecodeLimits& limits) {
  const auto counts = read_draco_counts(bytes);
  if (!counts) return fail(counts.error());
  if (counts->vertices > limits.max_vertices || counts->faces > limits.max_triangles) {
    return fail(fmt::format("the payload claims {} vertices and {} triangles; at most {} and {} are accepted",
                            counts->vertices, counts->faces, limits.max_vertices, limits.max_triangles));
  }
  if (counts->faces > kMaxTrianglesPerByte * bytes.size()) {
    return fail("the payload claims more triangles than its bytes can hold");
  }
  return {};
}

Result<Submesh> decode_checked(std::span<const std::byte> bytes) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::Mesh mesh;
  ExpectedMeshDecoder decoder;
  if (const auto status = decoder.Decode(draco::DecoderOptions{}, &buffer, &mesh); !status.ok()) {
    return fail(fmt::format("the Draco payload is damaged ({})", status.error_msg_string()));
  }
  if (buffer.remaining_size() != 0) return fail("bytes follow after the Draco payload's mesh");
  auto submesh = to_submesh(mesh);
  if (!submesh) return submesh;
  if (auto ok = validate(*submesh); !ok) return fail("the Draco payload", ok.error());
  if (!is_on_lattice(*submesh)) return fail("the Draco payload has positions off the scene's lattice");
  return submesh;
}

Result<Submesh> decode_mesh(std::span<const std::byte> bytes, const DecodeLimits& limits) {
  if (auto ok = check_claims(bytes, limits); !ok) return fail(ok.error());
  try {
    return decode_checked(bytes);
  } catch (const std::exception& error) {
    return fail(fmt::format("the Draco payload is damaged ({})", error.what()));
  }
}

/// The picture is decoded to see that it can be; who draws it does so again.
Result<Submesh> decode_with_texture(std::span<const std::byte> bytes, const DecodeLimits& limits) {
  const auto frame = split_texture_frame(bytes);
  if (!frame) return fail(frame.error());
  auto texture = make_projected_texture({frame->jpeg.begin(), frame->jpeg.end()}, frame->projection);
  if (!texture) return fail("the payload", texture.error());
  if (const auto picture = decode_jpeg(frame->jpeg); !picture) return fail("the payload's texture", picture.error());
  auto submesh = decode_mesh(frame->mesh, limits);
  if (!submesh) return submesh;
  submesh->texture = std::move(*texture);
  if (auto ok = validate(*submesh); !ok) return fail("the payload", ok.error());
  return submesh;
}

}  // namespace

Result<Submesh> decode(std::span<const std::byte> bytes, const DecodeLimits& limits) {
  if (bytes.size() > limits.max_bytes) {
    return fail(fmt::format("the payload has {} bytes; at most {} are accepted", bytes.size(), limits.max_bytes));
  }
  return is_texture_frame(bytes) ? decode_with_texture(bytes, limits) : decode_mesh(bytes, limits);
}

}  // namespace meshloop
