#include "common/codec/mesh_codec.h"

#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>

#include "common/codec/color_transform.h"
#include "common/codec/draco_header.h"
#include "common/codec/texture_frame.h"
#include "common/mesh/lattice.h"

namespace meshloop {
namespace {

/// Draco rounds with floor(x + 0.5f), which is exact below 2^23 only.
constexpr int kMaxBits = 23;
constexpr double kMaxWidth_m = ((1 << kMaxBits) - 1) * static_cast<double>(kLatticeSpacing_m);

/// Edgebreaker leaves out triangles that name a vertex twice. Their second use gets a vertex of its own.
Submesh with_distinct_corners(const Submesh& submesh) {
  Submesh distinct = submesh;
  const auto copy_vertex = [&distinct](std::uint32_t& index) {
    distinct.positions.push_back(Eigen::Vector3f{distinct.positions[index]});
    if (distinct.has_colors()) distinct.colors.push_back(Rgb8{distinct.colors[index]});
    index = static_cast<std::uint32_t>(distinct.positions.size() - 1);
  };
  for (auto& [a, b, c] : distinct.triangles) {
    if (b == a) copy_vertex(b);
    if (c == a || c == b) copy_vertex(c);
  }
  return distinct;
}

/// Colours in coarse steps, as a snapshot's are, are written as such.
draco::DataType color_type(const std::vector<Rgb8>& colors) {
  const auto in_steps = [](const Rgb8& color) { return (color.r | color.g | color.b) % kCoarseColorStep == 0; };
  return std::all_of(colors.begin(), colors.end(), in_steps) ? draco::DT_INT8 : draco::DT_UINT8;
}

template <class T>
int add_attribute(draco::Mesh& mesh, draco::GeometryAttribute::Type kind, draco::DataType type,
                  const std::vector<T>& values) {
  static_assert(std::is_trivially_destructible_v<T>);
  draco::GeometryAttribute attribute;
  attribute.Init(kind, nullptr, 3, type, kind == draco::GeometryAttribute::COLOR, sizeof(T), 0);
  const int id = mesh.AddAttribute(attribute, true, static_cast<std::uint32_t>(values.size()));
  mesh.attribute(id)->buffer()->Write(0, values.data(), values.size() * sizeof(T));
  return id;
}

struct DracoMesh {
  draco::Mesh mesh;
  int position_id = -1;
  int color_id = -1;
};

void fill(DracoMesh& target, const Submesh& submesh) {
  auto& mesh = target.mesh;
  mesh.set_num_points(static_cast<std::uint32_t>(submesh.positions.size()));
  target.position_id = add_attribute(mesh, draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, submesh.positions);
  if (submesh.has_colors()) {
    const auto type = color_type(submesh.colors);
    std::vector<CodedColor> coded(submesh.colors.size());
    std::transform(submesh.colors.begin(), submesh.colors.end(), coded.begin(),
                   [=](const Rgb8& color) { return to_coded(color, color_step(type)); });
    target.color_id = add_attribute(mesh, draco::GeometryAttribute::COLOR, type, coded);
  }
  mesh.SetNumFaces(submesh.triangles.size());
  for (std::uint32_t t = 0; t < submesh.triangles.size(); ++t) {
    const auto& [a, b, c] = submesh.triangles[t];
    mesh.SetFace(draco::FaceIndex(t), {draco::PointIndex(a), draco::PointIndex(b), draco::PointIndex(c)});
  }
}

/// The lattice that Draco quantises on: the scene's, as coarse as the submesh allows, from its lower corner.
struct Quantisation {
  Eigen::Vector3f origin;
  int bits = 1;
  float range = 0;
};

Result<Quantisation> quantisation_of(const Submesh& submesh) {
  const auto bounds = submesh.bounds();
  const float spacing_m = kLatticeSpacing_m * static_cast<float>(coarsening_of(submesh));
  const double width_m = bounds.sizes().cast<double>().maxCoeff();
  Quantisation chosen{bounds.min()};
  while (chosen.bits <= kMaxBits && width_m / spacing_m > (1 << chosen.bits) - 1) ++chosen.bits;
  if (width_m > kMaxWidth_m) {
    return fail(fmt::format("the submesh is {:.0f} m wide, and at most {:.0f} m can be encoded; split it", width_m,
                            kMaxWidth_m));
  }
  chosen.range = spacing_m * static_cast<float>((1 << chosen.bits) - 1);
  return chosen;
}

/// Draco keeps options as text, and its own setters write six decimals, which is not enough for the lattice: a point
/// of it has up to twelve.
draco::Options exact_quantisation(const Quantisation& quantisation) {
  const auto& origin = quantisation.origin;
  draco::Options options;
  options.SetInt("quantization_bits", quantisation.bits);
  options.SetString("quantization_origin", fmt::format("{:.12f} {:.12f} {:.12f}", origin.x(), origin.y(), origin.z()));
  options.SetString("quantization_range", fmt::format("{:.12f}", quantisation.range));
  return options;
}

/// What Draco chooses at a speed is the shorter one in large submeshes; small ones are written both ways.
enum class Traversal { by_speed, standard };
constexpr std::size_t kSmall = 1000;

Result<std::vector<std::byte>> encode_with(const DracoMesh& source, const Quantisation& quantisation, int speed,
                                           Traversal traversal) {
  auto options = draco::EncoderOptions::CreateDefaultOptions();
  options.SetAttributeOptions(source.position_id, exact_quantisation(quantisation));
  if (traversal == Traversal::standard)
    options.SetGlobalInt("edgebreaker_method", draco::MESH_EDGEBREAKER_STANDARD_ENCODING);
  draco::ExpertEncoder encoder{source.mesh};
  encoder.Reset(options);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetSpeedOptions(speed, speed);
  // A parallelogram doubles the noise of a camera's pixels; the neighbour's colour predicts better.
  if (source.color_id >= 0) encoder.SetAttributePredictionScheme(source.color_id, draco::PREDICTION_DIFFERENCE);
  draco::EncoderBuffer buffer;
  if (const auto status = encoder.EncodeToBuffer(&buffer); !status.ok()) {
    return fail(fmt::format("Draco could not encode the submesh: {}", status.error_msg_string()));
  }
  const auto bytes = std::as_bytes(std::span{buffer.data(), buffer.size()});
  return std::vector<std::byte>{bytes.begin(), bytes.end()};
}

Result<std::vector<std::byte>> encode_valid(const Submesh& submesh, int speed) {
  const auto quantisation = quantisation_of(submesh);
  if (!quantisation) return fail(quantisation.error());
  DracoMesh source;
  fill(source, with_distinct_corners(submesh));
  auto bytes = encode_with(source, *quantisation, speed, Traversal::by_speed);
  if (!bytes) return bytes;
  const std::size_t triangles = submesh.triangles.size();
  const bool is_refused = triangles > kMaxTrianglesPerByte * bytes->size();
  if (triangles > kSmall && !is_refused) return bytes;
  auto standard = encode_with(source, *quantisation, speed, Traversal::standard);
  return is_refused || (standard && standard->size() < bytes->size()) ? standard : bytes;
}

}  // namespace

Result<std::vector<std::byte>> encode(const Submesh& submesh, const EncodeOptions& options) {
  if (auto ok = validate(submesh); !ok) return fail(ok.error());
  if (!is_on_lattice(submesh)) {
    return fail("the submesh has positions off the scene's lattice; move them there with snap_to_lattice");
  }
  try {
    auto mesh = encode_valid(submesh, std::clamp(options.speed, 0, 10));
    if (!mesh || !submesh.texture) return mesh;
    return join_texture_frame(*mesh, *submesh.texture);
  } catch (const std::exception& error) {
    return fail(fmt::format("Draco could not encode the submesh: {}", error.what()));
  }
}

}  // namespace meshloop
