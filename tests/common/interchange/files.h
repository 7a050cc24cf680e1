#pragma once
// Files and models that the interchange tests share.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <string>
#include <tuple>
#include <vector>

#include "common/mesh/model.h"

namespace meshloop::test {

/// A folder of its own for each test, gone afterwards.
class Folder : public testing::Test {
 protected:
  Folder() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              (std::string{"meshloop-"} + test->name() + "-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  ~Folder() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& name, const std::string& content) const {
    std::ofstream{folder_ / name, std::ios::binary} << content;
    return folder_ / name;
  }
  [[nodiscard]] std::filesystem::path path(const std::string& name) const { return folder_ / name; }

  [[nodiscard]] std::vector<std::string> entries() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator{folder_}) names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  }

  std::filesystem::path folder_;
};

/// A grid of cells x cells squares with all 256 values in its colours.
inline Submesh grid(int cells, float size_m = 0.0625f, bool colored = true) {
  Submesh mesh;
  for (int y = 0; y <= cells; ++y) {
    for (int x = 0; x <= cells; ++x) {
      mesh.positions.emplace_back(static_cast<float>(x) * size_m, static_cast<float>(y) * size_m,
                                  static_cast<float>((x * y) % 5) * size_m / 8);
      const auto i = static_cast<std::uint8_t>(mesh.positions.size());
      if (colored) mesh.colors.push_back({i, static_cast<std::uint8_t>(255 - i), static_cast<std::uint8_t>(3 * i)});
    }
  }
  const auto row = static_cast<std::uint32_t>(cells + 1);
  for (std::uint32_t y = 0; y + 1 < row; ++y) {
    for (std::uint32_t x = 0; x + 1 < row; ++x) {
      const std::uint32_t a = y * row + x;
      mesh.triangles.push_back({a, a + 1, a + row});
      mesh.triangles.push_back({a + 1, a + row + 1, a + row});
    }
  }
  return mesh;
}

using Corner = std::tuple<float, float, float, int, int, int>;
using Face = std::array<Corner, 3>;

/// The triangles as a sorted list of exact positions and colours, each turned to its smallest order.
inline std::vector<Face> faces_of(const Submesh& submesh) {
  std::vector<Face> faces;
  for (const auto& triangle : submesh.triangles) {
    Face face;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& p = submesh.positions[triangle[k]];
      const Rgb8 color = submesh.has_colors() ? submesh.colors[triangle[k]] : Rgb8{};
      face[k] = {p.x(), p.y(), p.z(), color.r, color.g, color.b};
    }
    const Face once{face[1], face[2], face[0]}, twice{face[2], face[0], face[1]};
    faces.push_back(std::min({face, once, twice}));
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

/// Two nodes: one with colours, one moved and turned by 90 degrees (exact in floating point), with a difficult name.
inline Model two_nodes() {
  Model model;
  model.revision = 7;
  model.nodes.push_back(make_node(1, "wall", grid(15)));
  Pose T_world_node = Pose::Identity();
  T_world_node.linear() << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  T_world_node.translation() = Eigen::Vector3d{0.5, -0.25, 2};
  model.nodes.push_back(make_node(4, "b\"ox\\ \xc3\xa4\n\xff", grid(3), T_world_node));
  return model;
}

}  // namespace meshloop::test
