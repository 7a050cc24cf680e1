#pragma once
// Scenes that the store's tests share.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "server/store/scene_store.h"

namespace meshloop::test {

/// A folder of its own for each test, gone afterwards.
class SceneFolder : public testing::Test {
 protected:
  SceneFolder() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              (std::string{"meshloop-"} + test->name() + "-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    scene_ = folder_ / "a.scene";
  }
  ~SceneFolder() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
  std::filesystem::path scene_;
};

/// A wavy square of 2 * cells * cells triangles; `seed` makes different ones.
inline Submesh patch(int cells, int seed) {
  Submesh mesh;
  for (int y = 0; y <= cells; ++y) {
    for (int x = 0; x <= cells; ++x) {
      mesh.positions.emplace_back(static_cast<float>(x) / 64, static_cast<float>(y) / 64,
                                  static_cast<float>((x * y + seed) % 97) / 4096);
      mesh.colors.push_back(
          {static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y), static_cast<std::uint8_t>(seed)});
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

inline AddNode add(NodeId id, int seed, int cells = 4) {
  return {make_node(id, "node " + std::to_string(id), patch(cells, seed))};
}

inline std::unique_ptr<SceneStore> open_or_die(const std::filesystem::path& file, bool create = true) {
  auto store = SceneStore::open(file, create);
  if (!store) throw std::runtime_error(store.error().message);
  return std::move(*store);
}

/// Bit for bit, but for the revision.
inline void expect_same_content(const Model& a, const Model& b) {
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (std::size_t i = 0; i < a.nodes.size(); ++i) {
    EXPECT_EQ(a.nodes[i].id, b.nodes[i].id);
    EXPECT_EQ(a.nodes[i].name, b.nodes[i].name);
    EXPECT_EQ(a.nodes[i].T_world_node.matrix(), b.nodes[i].T_world_node.matrix());
    EXPECT_EQ(a.nodes[i].hash, b.nodes[i].hash);
    EXPECT_EQ(content_hash(*a.nodes[i].submesh), b.nodes[i].hash);
    EXPECT_EQ(content_hash(*b.nodes[i].submesh), b.nodes[i].hash);
  }
}

inline std::string content_of(const std::filesystem::path& file) {
  std::ifstream in{file, std::ios::binary};
  return {std::istreambuf_iterator<char>{in}, {}};
}

inline void write_content(const std::filesystem::path& file, const std::string& content) {
  std::ofstream{file, std::ios::binary} << content;
}

}  // namespace meshloop::test
