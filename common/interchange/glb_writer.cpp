#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <span>
#include <string>

#include "common/interchange/color_space.h"
#include "common/interchange/gltf_texture.h"
#include "common/interchange/json_text.h"
#include "common/interchange/texture_coordinates.h"
#include "common/interchange/writers.h"

namespace meshloop {
namespace {

// glTF 2.0 specification, sections 3.6 (binary data), 3.7 (geometry) and 4 (GLB container).
constexpr std::uint32_t kMagic = 0x46546c67, kVersion = 2, kJson = 0x4e4f534a, kBinary = 0x004e4942;
constexpr int kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
constexpr int kLinear = 9729, kClampToEdge = 33071;

/// Comma-separated JSON objects.
struct JsonList {
  std::string text;
  std::size_t count = 0;

  std::size_t add(const std::string& object) {
    if (count > 0) text += ',';
    text += object;
    return count++;
  }
};

struct Document {
  JsonList nodes, meshes, accessors, views, materials, images;
  std::vector<std::byte> binary;
  /// Pieces of one surface share their texture.
  std::map<const ProjectedTexture*, std::size_t> material_of_texture;
};

template <class T>
void append(std::vector<std::byte>& bytes, const std::vector<T>& values) {
  const auto view = std::as_bytes(std::span{values});
  bytes.insert(bytes.end(), view.begin(), view.end());
}

/// All elements have sizes that are multiples of four, so that every view starts aligned.
template <class T>
std::size_t add_accessor(Document& out, const std::vector<T>& values, int target, const std::string& format) {
  static_assert(sizeof(T) % 4 == 0);
  const auto view = out.views.add(fmt::format(R"({{"buffer":0,"byteOffset":{},"byteLength":{},"target":{}}})",
                                              out.binary.size(), values.size() * sizeof(T), target));
  append(out.binary, values);
  return out.accessors.add(fmt::format(R"({{"bufferView":{},{}}})", view, format));
}

std::size_t add_positions(Document& out, const std::vector<Eigen::Vector3f>& positions) {
  Eigen::AlignedBox3f box;
  for (const auto& p : positions) box.extend(p);
  const auto &lo = box.min(), &hi = box.max();
  return add_accessor(out, positions, kArrayBuffer,
                      fmt::format(R"("componentType":{},"count":{},"type":"VEC3","min":[{},{},{}],"max":[{},{},{}])",
                                  kFloat, positions.size(), lo.x(), lo.y(), lo.z(), hi.x(), hi.y(), hi.z()));
}

std::size_t add_colors(Document& out, const Submesh& submesh) {
  std::array<std::uint16_t, 256> linear{};
  for (std::size_t i = 0; i < linear.size(); ++i) {
    linear[i] = static_cast<std::uint16_t>(std::lround(65535 * linear_from_srgb(static_cast<std::uint8_t>(i))));
  }
  std::vector<std::array<std::uint16_t, 4>> colors;
  colors.reserve(submesh.colors.size());
  for (const auto& c : submesh.colors) colors.push_back({linear[c.r], linear[c.g], linear[c.b], 65535});
  return add_accessor(
      out, colors, kArrayBuffer,
      fmt::format(R"("componentType":{},"normalized":true,"count":{},"type":"VEC4")", kUnsignedShort, colors.size()));
}

std::size_t add_image(Document& out, const std::vector<std::byte>& jpeg) {
  const auto view =
      out.views.add(fmt::format(R"({{"buffer":0,"byteOffset":{},"byteLength":{}}})", out.binary.size(), jpeg.size()));
  append(out.binary, jpeg);
  out.binary.resize((out.binary.size() + 3) / 4 * 4);
  return out.images.add(fmt::format(R"({{"bufferView":{},"mimeType":"image/jpeg"}})", view));
}

/// Textures have the numbers of their images.
std::size_t material_of(Document& out, const ProjectedTexture& texture) {
  const auto [entry, is_new] = out.material_of_texture.try_emplace(&texture, 0);
  if (!is_new) return entry->second;
  const auto image = add_image(out, texture.jpeg);
  std::string projection;
  for (const float value : texture.projection.reshaped()) {
    projection += fmt::format("{}{}", projection.empty() ? "" : ",", value);
  }
  entry->second = out.materials.add(
      fmt::format(R"({{"name":"picture {}","doubleSided":true,"pbrMetallicRoughness":{{"metallicFactor":0,)"
                  R"("roughnessFactor":1,"baseColorTexture":{{"index":{}}}}},"extras":{{"{}":[{}]}}}})",
                  image + 1, image, kProjectionKey, projection));
  return entry->second;
}

std::size_t add_primitive(Document& out, const std::string& name, const std::string& attributes,
                          const std::vector<Triangle>& triangles, std::size_t material) {
  const auto indices =
      add_accessor(out, triangles, kElementArrayBuffer,
                   fmt::format(R"("componentType":{},"count":{},"type":"SCALAR")", kUnsignedInt, triangles.size() * 3));
  return out.meshes.add(
      fmt::format(R"({{"name":{},"primitives":[{{"attributes":{{{}}},"indices":{},"material":{}}}]}})", name,
                  attributes, indices, material));
}

std::size_t add_textured_mesh(Document& out, const Submesh& submesh, const std::string& name) {
  const auto mesh = with_coordinates(submesh);
  const auto positions = add_positions(out, mesh.positions);
  const auto coordinates =
      add_accessor(out, mesh.coordinates, kArrayBuffer,
                   fmt::format(R"("componentType":{},"count":{},"type":"VEC2")", kFloat, mesh.coordinates.size()));
  return add_primitive(out, name, fmt::format(R"("POSITION":{},"TEXCOORD_0":{})", positions, coordinates),
                       mesh.triangles, material_of(out, *submesh.texture));
}

std::size_t add_mesh(Document& out, const Submesh& submesh, const std::string& name) {
  if (submesh.texture) return add_textured_mesh(out, submesh, name);
  std::string attributes = fmt::format(R"("POSITION":{})", add_positions(out, submesh.positions));
  if (submesh.has_colors()) attributes += fmt::format(R"(,"COLOR_0":{})", add_colors(out, submesh));
  return add_primitive(out, name, attributes, submesh.triangles, 0);
}

void add_node(Document& out, const Node& node) {
  const std::string name = json_string(node.name);
  const auto mesh = add_mesh(out, *node.submesh, name);
  const Eigen::Matrix4d& m = node.T_world_node.matrix();
  std::string matrix;
  for (Eigen::Index i = 0; i < 16; ++i) matrix += fmt::format("{}{}", i > 0 ? "," : "", m(i % 4, i / 4));
  out.nodes.add(fmt::format(R"({{"name":{},"mesh":{},"matrix":[{}]}})", name, mesh, matrix));
}

/// glTF knows no empty lists.
std::string json_of_textures(const Document& out) {
  if (out.images.count == 0) return {};
  JsonList textures;
  for (std::size_t i = 0; i < out.images.count; ++i) textures.add(fmt::format(R"({{"sampler":0,"source":{}}})", i));
  return fmt::format(
      R"("images":[{}],"textures":[{}],"samplers":[{{"magFilter":{},"minFilter":{},"wrapS":{},"wrapT":{}}}],)",
      out.images.text, textures.text, kLinear, kLinear, kClampToEdge, kClampToEdge);
}

std::string json_of(const Document& out) {
  std::string roots;
  for (std::size_t i = 0; i < out.nodes.count; ++i) roots += fmt::format("{}{}", i > 0 ? "," : "", i);
  return fmt::format(R"({{"asset":{{"version":"2.0","generator":"meshloop {}"}},"scene":0,"scenes":[{{"nodes":[{}]}}],)"
                     R"("nodes":[{}],"meshes":[{}],"materials":[{}],{})"
                     R"("accessors":[{}],"bufferViews":[{}],"buffers":[{{"byteLength":{}}}]}})",
                     MESHLOOP_VERSION, roots, out.nodes.text, out.meshes.text, out.materials.text,
                     json_of_textures(out), out.accessors.text, out.views.text, out.binary.size());
}

void append_words(std::vector<std::byte>& bytes, std::initializer_list<std::uint32_t> words) {
  append(bytes, std::vector<std::uint32_t>{words});
}

}  // namespace

Result<std::vector<std::byte>> to_glb(const Model& model) {
  Document out;
  out.materials.add(
      R"({"name":"surface","doubleSided":true,"pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":1}})");
  for (const auto& node : model.nodes) add_node(out, node);
  std::string json = json_of(out);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::uint64_t size = 12 + 8 + json.size() + 8 + out.binary.size();
  if (size > std::numeric_limits<std::uint32_t>::max()) {
    return fail("the model is too large for one GLB file (4 GB); export it as PLY");
  }
  std::vector<std::byte> bytes;
  bytes.reserve(size);
  append_words(bytes, {kMagic, kVersion, static_cast<std::uint32_t>(size)});
  append_words(bytes, {static_cast<std::uint32_t>(json.size()), kJson});
  const auto text = std::as_bytes(std::span{json});
  bytes.insert(bytes.end(), text.begin(), text.end());
  append_words(bytes, {static_cast<std::uint32_t>(out.binary.size()), kBinary});
  append(bytes, out.binary);
  return bytes;
}

}  // namespace meshloop
