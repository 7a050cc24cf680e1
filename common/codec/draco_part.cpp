#include "common/codec/draco_part.h"

#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/mesh/mesh.h>
#include <fmt/format.h>

namespace meshloop {
namespace {

/// Positions: all that encode() has Draco write.
bool has_expected_attributes(const draco::PointCloud& cloud) {
  if (cloud.num_attributes() != 1) return false;
  const auto& position = *cloud.attribute(0);
  return position.attribute_type() == draco::GeometryAttribute::POSITION && position.num_components() == 3 &&
         position.data_type() == draco::DT_FLOAT32;
}

/// Stops after the attributes' descriptions when they are not the expected ones, so that no value of another kind is
/// decoded: texture coordinates and normals are where decoding can become slow or crash.
class ExpectedMeshDecoder : public draco::MeshEdgebreakerDecoder {
 protected:
  bool CreateAttributesDecoder(int32_t id) override {
    return id < 1 && draco::MeshEdgebreakerDecoder::CreateAttributesDecoder(id);
  }
  bool DecodeAllAttributes() override {
    return has_expected_attributes(*point_cloud()) && draco::MeshEdgebreakerDecoder::DecodeAllAttributes();
  }
};

bool has_all_values(const draco::PointAttribute& attribute) {
  const auto stride = static_cast<std::size_t>(attribute.byte_stride());
  return stride == sizeof(Eigen::Vector3f) && attribute.buffer() != nullptr &&
         attribute.buffer()->data_size() >= attribute.size() * stride;
}

/// Numbers vertices as the triangles come to them.
class Numbering {
 public:
  Numbering(const draco::Mesh& mesh, DracoPart& part)
      : positions_{*mesh.attribute(0)}, number_(mesh.num_points(), kNone), part_{part} {}

  /// False for a point that is not there.
  bool take(draco::PointIndex point, std::uint32_t& vertex) {
    if (point.value() >= number_.size()) return false;
    auto& number = number_[point.value()];
    if (number == kNone && !add(point, number)) return false;
    vertex = number;
    return true;
  }

 private:
  bool add(draco::PointIndex point, std::uint32_t& number) {
    const auto written = positions_.mapped_index(point);
    if (written.value() >= positions_.size()) return false;
    number = static_cast<std::uint32_t>(part_.written.size());
    part_.written.push_back(written.value());
    positions_.GetValue(written, part_.mesh.positions.emplace_back().data());
    return true;
  }

  static constexpr std::uint32_t kNone = ~0U;
  const draco::PointAttribute& positions_;
  std::vector<std::uint32_t> number_;
  DracoPart& part_;
};

}  // namespace

Result<DracoPart> read_draco_part(std::span<const std::byte> payload) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(payload.data()), payload.size());
  draco::Mesh mesh;
  ExpectedMeshDecoder decoder;
  if (const auto status = decoder.Decode(draco::DecoderOptions{}, &buffer, &mesh); !status.ok()) {
    return fail(fmt::format("the Draco payload is damaged ({})", status.error_msg_string()));
  }
  DracoPart part;
  part.bytes = payload.size() - static_cast<std::size_t>(buffer.remaining_size());
  if (!has_all_values(*mesh.attribute(0))) return fail("the Draco payload has fewer values than vertices");
  Numbering numbering{mesh, part};
  part.mesh.triangles.resize(mesh.num_faces());
  for (std::uint32_t t = 0; t < mesh.num_faces(); ++t) {
    const auto& face = mesh.face(draco::FaceIndex(t));
    for (std::size_t k = 0; k < 3; ++k) {
      if (!numbering.take(face[k], part.mesh.triangles[t][k]))
        return fail("the Draco payload has triangles without vertices");
    }
  }
  if (auto ok = validate(part.mesh); !ok) return fail("the Draco payload", ok.error());
  return part;
}

}  // namespace meshloop
