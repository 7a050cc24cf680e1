#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string>

#include "common/interchange/color_space.h"
#include "common/interchange/json_text.h"
#include "common/interchange/writers.h"

namespace meshloop {
namespace {

// glTF 2.0 specification, sections 3.6 (binary data), 3.7 (geometry) and 4 (GLB container).
constexpr std::uint32_t kMagic = 0x46546c67, kVersion = 2, kJson = 0x4e4f534a, kBinary = 0x004e4942;
constexpr int kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;

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
  JsonList nodes, meshes, accessors, views;
  std::vector<std::byte> binary;
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

std::size_t add_positions(Document& out, const Submesh& submesh) {
  const auto box = submesh.bounds();
  const auto &lo = box.min(), &hi = box.max();
  return add_accessor(out, submesh.positions, kArrayBuffer,
                      fmt::format(R"("componentType":{},"count":{},"type":"VEC3","min":[{},{},{}],"max":[{},{},{}])",
                                  kFloat, submesh.positions.size(), lo.x(), lo.y(), lo.z(), hi.x(), hi.y(), hi.z()));
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

std::size_t add_mesh(Document& out, const Submesh& submesh, const std::string& name) {
  std::string attributes = fmt::format(R"("POSITION":{})", add_positions(out, submesh));
  if (submesh.has_colors()) attributes += fmt::format(R"(,"COLOR_0":{})", add_colors(out, submesh));
  const auto indices = add_accessor(
      out, submesh.triangles, kElementArrayBuffer,
      fmt::format(R"("componentType":{},"count":{},"type":"SCALAR")", kUnsignedInt, submesh.triangles.size() * 3));
  return out.meshes.add(fmt::format(R"({{"name":{},"primitives":[{{"attributes":{{{}}},"indices":{},"material":0}}]}})",
                                    name, attributes, indices));
}

void add_node(Document& out, const Node& node) {
  const std::string name = json_string(node.name);
  const auto mesh = add_mesh(out, *node.submesh, name);
  const Eigen::Matrix4d& m = node.T_world_node.matrix();
  std::string matrix;
  for (Eigen::Index i = 0; i < 16; ++i) matrix += fmt::format("{}{}", i > 0 ? "," : "", m(i % 4, i / 4));
  out.nodes.add(fmt::format(R"({{"name":{},"mesh":{},"matrix":[{}]}})", name, mesh, matrix));
}

std::string json_of(const Document& out) {
  std::string roots;
  for (std::size_t i = 0; i < out.nodes.count; ++i) roots += fmt::format("{}{}", i > 0 ? "," : "", i);
  return fmt::format(R"({{"asset":{{"version":"2.0","generator":"meshloop {}"}},"scene":0,"scenes":[{{"nodes":[{}]}}],)"
                     R"("nodes":[{}],"meshes":[{}],"materials":[{{"name":"surface","doubleSided":true,)"
                     R"("pbrMetallicRoughness":{{"metallicFactor":0,"roughnessFactor":1}}}}],)"
                     R"("accessors":[{}],"bufferViews":[{}],"buffers":[{{"byteLength":{}}}]}})",
                     MESHLOOP_VERSION, roots, out.nodes.text, out.meshes.text, out.accessors.text, out.views.text,
                     out.binary.size());
}

void append_words(std::vector<std::byte>& bytes, std::initializer_list<std::uint32_t> words) {
  append(bytes, std::vector<std::uint32_t>{words});
}

}  // namespace

Result<std::vector<std::byte>> to_glb(const Model& model) {
  Document out;
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
