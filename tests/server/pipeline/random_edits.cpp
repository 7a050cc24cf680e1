#include "random_edits.h"

#include <fmt/format.h>

#include <array>
#include <set>

namespace meshloop::test {
namespace {

float random_number(std::mt19937& random) {
  return std::uniform_real_distribution<float>{-2, 2}(random);
}

/// A strip of triangles; every third one has no colours.
Submesh random_submesh(std::mt19937& random) {
  Submesh mesh;
  const auto count = static_cast<std::uint32_t>(1 + random() % 40);
  const bool has_colors = random() % 3 != 0;
  for (std::uint32_t i = 0; i < count + 2; ++i) {
    const float x = static_cast<float>(i / 2) / 16;
    const float y = i % 2 == 0 ? 0.0F : 1.0F;
    mesh.positions.emplace_back(x, y, random_number(random));
    if (has_colors) mesh.colors.push_back({static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(i), 7});
  }
  for (std::uint32_t i = 0; i < count; ++i) mesh.triangles.push_back({i, i + 1, i + 2});
  return mesh;
}

/// Without some of the triangles, and some of the others cut in three.
Submesh with_a_cut(std::mt19937& random, const Submesh& whole) {
  Submesh mesh{whole.positions, whole.colors, {}};
  for (const auto& [a, b, c] : whole.triangles) {
    const auto dice = random() % 8;
    if (dice == 0) continue;
    if (dice > 1) {
      mesh.triangles.push_back({a, b, c});
      continue;
    }
    const auto middle = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.push_back((mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) / 3);
    if (whole.has_colors()) mesh.colors.push_back(mesh.colors[a]);
    for (const auto& [from, to] : {std::array{a, b}, std::array{b, c}, std::array{c, a}}) {
      mesh.triangles.push_back({from, to, middle});
    }
  }
  if (mesh.triangles.empty()) mesh.triangles.push_back(whole.triangles.front());
  return mesh;
}

/// The same place in other bits.
Pose with_other_zeros(Pose pose) {
  for (Eigen::Index i = 0; i < 3; ++i) {
    double& number = pose.translation()[i];
    if (number == 0) number = -number;
  }
  return pose;
}

}  // namespace

Pose random_pose(std::mt19937& random) {
  constexpr std::array kSome{0.0, -0.0, 1.0 / 3, -2e-300, 1e6};
  Eigen::Vector3d translation;
  for (double& number : translation) {
    number = random() % 2 == 0 ? kSome[random() % kSome.size()] : static_cast<double>(random_number(random));
  }
  Eigen::Vector3d axis{1, static_cast<double>(random_number(random)), 0.5};
  return make_pose(translation,
                   Eigen::Quaterniond{Eigen::AngleAxisd{0.5 * static_cast<double>(random() % 7), axis.normalized()}});
}

std::vector<Edit> random_edits(std::mt19937& random, const Model& model, NodeId free_id) {
  std::vector<Edit> edits;
  std::set<NodeId> gone;
  for (auto count = 1 + random() % 3; count > 0; --count) {
    const auto kind = random() % 5;
    if (model.nodes.empty() || kind < 2) {
      auto name = fmt::format("patch {} \xc3\xa4", free_id);
      edits.emplace_back(AddNode{make_node(free_id++, std::move(name), random_submesh(random), random_pose(random))});
      continue;
    }
    const Node& node = model.nodes[random() % model.nodes.size()];
    if (gone.contains(node.id)) continue;
    if (kind == 2) {
      const bool is_far = random() % 3 != 0;
      edits.emplace_back(MoveNode{node.id, is_far ? random_pose(random) : with_other_zeros(node.T_world_node)});
    }
    if (kind == 3) {
      edits.emplace_back(ReplaceSubmesh{node.id, std::make_shared<const Submesh>(with_a_cut(random, *node.submesh))});
    }
    if (kind == 4) {
      edits.emplace_back(RemoveNode{node.id});
      gone.insert(node.id);
    }
  }
  return edits;
}

}  // namespace meshloop::test
