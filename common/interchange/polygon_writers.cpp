#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <span>
#include <string>

#include "common/interchange/writers.h"

namespace meshloop {
namespace {

Eigen::Vector3f in_world(const Node& node, const Eigen::Vector3f& p) {
  return (node.T_world_node * p.cast<double>()).cast<float>();
}

template <class T>
void append(std::vector<std::byte>& bytes, const T& value) {
  const auto view = std::as_bytes(std::span{&value, 1});
  bytes.insert(bytes.end(), view.begin(), view.end());
}

struct Totals {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  bool has_colors = false;
};

Totals totals_of(const Model& model) {
  Totals totals;
  for (const auto& node : model.nodes) {
    totals.vertices += node.submesh->positions.size();
    totals.triangles += node.submesh->triangles.size();
    totals.has_colors |= node.submesh->has_colors() || node.submesh->texture;
  }
  return totals;
}

std::string ply_header(const Totals& totals) {
  return fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment meshloop, metres, world coordinates\nelement vertex {}\n"
      "property float x\nproperty float y\nproperty float z\n{}element face {}\n"
      "property list uchar uint vertex_indices\nend_header\n",
      totals.vertices, totals.has_colors ? "property uchar red\nproperty uchar green\nproperty uchar blue\n" : "",
      totals.triangles);
}

Status append_ply_vertices(std::vector<std::byte>& bytes, const Node& node, bool has_colors) {
  const Submesh& submesh = *node.submesh;
  const auto colors = vertex_colors(submesh);
  if (!colors) return fail(node.name, colors.error());
  for (std::size_t i = 0; i < submesh.positions.size(); ++i) {
    const Eigen::Vector3f p = in_world(node, submesh.positions[i]);
    for (const float value : {p.x(), p.y(), p.z()}) append(bytes, value);
    if (has_colors) append(bytes, colors->empty() ? kNoColor : (*colors)[i]);
  }
  return {};
}

/// A name on one line.
std::string line_of(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '\n' || c == '\r' || c == '\0'; }, ' ');
  return name;
}

Status append_obj_node(std::string& text, const Node& node, std::size_t first_index) {
  const Submesh& submesh = *node.submesh;
  const auto colors = vertex_colors(submesh);
  if (!colors) return fail(node.name, colors.error());
  auto out = std::back_inserter(text);
  fmt::format_to(out, "o {}\n", line_of(node.name));
  for (std::size_t i = 0; i < submesh.positions.size(); ++i) {
    const Eigen::Vector3f p = in_world(node, submesh.positions[i]);
    fmt::format_to(out, "v {} {} {}", p.x(), p.y(), p.z());
    if (!colors->empty()) {
      const Rgb8& c = (*colors)[i];
      fmt::format_to(out, " {:.5f} {:.5f} {:.5f}", c.r / 255.0, c.g / 255.0, c.b / 255.0);
    }
    text += '\n';
  }
  for (const auto& [a, b, c] : submesh.triangles) {
    fmt::format_to(out, "f {} {} {}\n", first_index + a, first_index + b, first_index + c);
  }
  return {};
}

}  // namespace

Result<std::vector<std::byte>> to_ply(const Model& model) {
  static_assert(sizeof(Rgb8) == 3);
  const Totals totals = totals_of(model);
  if (totals.vertices > std::numeric_limits<std::uint32_t>::max()) return fail("the model is too large for one file");
  const std::string header = ply_header(totals);
  std::vector<std::byte> bytes;
  bytes.reserve(header.size() + totals.vertices * 15 + totals.triangles * 13);
  const auto head = std::as_bytes(std::span{header});
  bytes.insert(bytes.end(), head.begin(), head.end());
  for (const auto& node : model.nodes) {
    if (auto done = append_ply_vertices(bytes, node, totals.has_colors); !done) return fail(done.error());
  }
  std::uint32_t first_index = 0;
  for (const auto& node : model.nodes) {
    for (const auto& triangle : node.submesh->triangles) {
      append(bytes, std::uint8_t{3});
      for (const auto index : triangle) append(bytes, first_index + index);
    }
    first_index += static_cast<std::uint32_t>(node.submesh->positions.size());
  }
  return bytes;
}

Result<std::vector<std::byte>> to_obj(const Model& model) {
  std::string text = "# meshloop, metres, world coordinates\n";
  std::size_t first_index = 1;
  for (const auto& node : model.nodes) {
    if (auto done = append_obj_node(text, node, first_index); !done) return fail(done.error());
    first_index += node.submesh->positions.size();
  }
  const auto bytes = std::as_bytes(std::span{text});
  return std::vector<std::byte>{bytes.begin(), bytes.end()};
}

}  // namespace meshloop
