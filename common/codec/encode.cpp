#include "common/codec/mesh_codec.h"

#include <draco/compression/mesh/mesh_edgebreaker_encoder.h>
#include <draco/mesh/mesh.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <optional>
#include <utility>

#include "common/codec/border_offsets.h"
#include "common/codec/draco_header.h"
#include "common/codec/draco_part.h"
#include "common/codec/mesh_tail.h"
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

void fill(draco::Mesh& mesh, const Submesh& submesh) {
  const auto& positions = submesh.positions;
  mesh.set_num_points(static_cast<std::uint32_t>(positions.size()));
  draco::GeometryAttribute attribute;
  attribute.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, sizeof(Eigen::Vector3f), 0);
  const int id = mesh.AddAttribute(attribute, true, static_cast<std::uint32_t>(positions.size()));
  mesh.attribute(id)->buffer()->Write(0, positions.data(), positions.size() * sizeof(Eigen::Vector3f));
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

Status check_width(const Submesh& submesh) {
  const double width_m = submesh.bounds().sizes().cast<double>().maxCoeff();
  if (width_m <= kMaxWidth_m) return {};
  return fail(
      fmt::format("the submesh is {:.0f} m wide, and at most {:.0f} m can be encoded; split it", width_m, kMaxWidth_m));
}

/// Of a submesh that is not too wide.
Quantisation quantisation_of(const Submesh& submesh, int coarsening) {
  const auto bounds = submesh.bounds();
  const float spacing_m = kLatticeSpacing_m * static_cast<float>(coarsening);
  const double width_m = bounds.sizes().cast<double>().maxCoeff();
  Quantisation chosen{bounds.min()};
  while (chosen.bits < kMaxBits && width_m / spacing_m > (1 << chosen.bits) - 1) ++chosen.bits;
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

/// The only attribute that Draco gets.
constexpr int kPositions = 0;

/// Valence is the shorter one in large submeshes; small ones are written both ways. Draco's own choice is standard for
/// all that have less than 1,000 triangles.
using Traversal = draco::MeshEdgebreakerConnectivityEncodingMethod;
constexpr Traversal kStandard = draco::MESH_EDGEBREAKER_STANDARD_ENCODING;
constexpr Traversal kValence = draco::MESH_EDGEBREAKER_VALENCE_ENCODING;
constexpr std::size_t kSmall = 1000;
constexpr int kSpeedOfStandard = 5;

struct Coded {
  std::vector<std::byte> bytes;
  /// The submesh's vertex of each position that was written.
  std::vector<std::uint32_t> vertices;
};

Result<Coded> encode_with(const draco::Mesh& source, const Quantisation& quantisation, int speed, Traversal traversal) {
  auto options = draco::EncoderOptions::CreateDefaultOptions();
  options.SetAttributeOptions(kPositions, exact_quantisation(quantisation));
  options.SetGlobalInt("edgebreaker_method", traversal);
  options.SetSpeed(speed, speed);
  draco::MeshEdgebreakerEncoder encoder;
  encoder.SetMesh(source);
  draco::EncoderBuffer buffer;
  if (const auto status = encoder.Encode(options, &buffer); !status.ok()) {
    return fail(fmt::format("Draco could not encode the submesh: {}", status.error_msg_string()));
  }
  Coded coded;
  const auto bytes = std::as_bytes(std::span{buffer.data(), buffer.size()});
  coded.bytes.assign(bytes.begin(), bytes.end());
  for (const auto& corner : encoder.GetAttributeEncodingData(kPositions)->encoded_attribute_value_index_to_corner_map) {
    coded.vertices.push_back(source.CornerToPointId(corner).value());
  }
  return coded;
}

/// With the traversal that gives the fewest bytes and that `decode` does not take for hostile.
Result<Coded> encode_shortest(const Submesh& submesh, int coarsening, int speed) {
  const auto quantisation = quantisation_of(submesh, coarsening);
  draco::Mesh source;
  fill(source, submesh);
  if (speed >= kSpeedOfStandard) return encode_with(source, quantisation, speed, kStandard);
  auto coded = encode_with(source, quantisation, speed, kValence);
  if (!coded) return coded;
  const std::size_t triangles = submesh.triangles.size();
  const bool is_refused = triangles > kMaxTrianglesPerByte * coded->bytes.size();
  if (triangles > kSmall && !is_refused) return coded;
  auto standard = encode_with(source, quantisation, speed, kStandard);
  if (!standard || is_refused) return standard;
  return standard->bytes.size() < coded->bytes.size() ? standard : coded;
}

std::vector<std::byte> with_tail(Coded coded, const MeshTail& tail, const std::vector<bool>& is_border) {
  const auto bytes = write_mesh_tail(tail, is_border);
  coded.bytes.insert(coded.bytes.end(), bytes.begin(), bytes.end());
  return std::move(coded.bytes);
}

/// Offsets: of each vertex from the lattice of this coarsening, or none. No bytes where Draco has made another vertex
/// of one that has an offset, and that one is not at the border.
Result<std::optional<std::vector<std::byte>>> encode_parts(const Submesh& submesh,
                                                           std::span<const LatticeOffset> offsets, int coarsening,
                                                           int speed) {
  auto coded = encode_shortest(submesh, coarsening, speed);
  if (!coded) return fail(coded.error());
  if (!submesh.has_colors() && offsets.empty()) return with_tail(std::move(*coded), {}, {});
  // Draco does not say how its decoder will number the vertices.
  const auto part = read_draco_part(coded->bytes);
  if (!part) return fail(part.error());
  const auto is_border = border_vertices(part->mesh.triangles, part->mesh.positions.size());
  MeshTail tail;
  if (!offsets.empty()) tail.coarsening = coarsening;
  for (std::size_t i = 0; i < part->written.size(); ++i) {
    const auto vertex = coded->vertices[part->written[i]];
    if (submesh.has_colors()) tail.colors.push_back(submesh.colors[vertex]);
    if (offsets.empty()) continue;
    if (!is_border[i] && offsets[vertex] != LatticeOffset{}) return std::nullopt;
    tail.offsets.push_back(offsets[vertex]);
  }
  return with_tail(std::move(*coded), tail, is_border);
}

Result<std::vector<std::byte>> encode_valid(const Submesh& submesh, int speed) {
  const Submesh distinct = with_distinct_corners(submesh);
  if (const int coarsening = coarsening_inside(distinct); coarsening > 1) {
    Submesh coarse = distinct;
    const auto offsets = take_offsets(coarse.positions, coarsening);
    auto bytes = encode_parts(coarse, offsets, coarsening, speed);
    if (!bytes) return fail(bytes.error());
    if (*bytes) return std::move(**bytes);
  }
  auto bytes = encode_parts(distinct, {}, coarsening_of(distinct), speed);
  if (!bytes) return fail(bytes.error());
  return std::move(**bytes);  // there are none only where there are offsets
}

}  // namespace

Result<std::vector<std::byte>> encode(const Submesh& submesh, const EncodeOptions& options) {
  if (auto ok = validate(submesh); !ok) return fail(ok.error());
  if (!is_on_lattice(submesh)) {
    return fail("the submesh has positions off the scene's lattice; move them there with snap_to_lattice");
  }
  if (auto ok = check_width(submesh); !ok) return fail(ok.error());
  try {
    auto mesh = encode_valid(submesh, std::clamp(options.speed, 0, 10));
    if (!mesh || !submesh.texture) return mesh;
    return join_texture_frame(*mesh, *submesh.texture);
  } catch (const std::exception& error) {
    return fail(fmt::format("Draco could not encode the submesh: {}", error.what()));
  }
}

}  // namespace meshloop
