#include "common/detail/hierarchy_builder.h"

#include <gtest/gtest.h>

#include "meshes.h"

namespace meshloop {
namespace {

TEST(HierarchyBuilder, HandsOverEachOnceInTheOrderOfAsking) {
  HierarchyBuilder builder{1};
  EXPECT_EQ(builder.take().hierarchy, nullptr);
  const auto small = std::make_shared<const Submesh>(test::ball(20));
  const auto large = std::make_shared<const Submesh>(test::hills(60));
  builder.ask(large);
  builder.ask(small);
  builder.wait();
  EXPECT_EQ(builder.take().submesh, large);
  const auto built = builder.take();
  EXPECT_EQ(built.submesh, small);
  ASSERT_NE(built.hierarchy, nullptr);
  EXPECT_EQ(built.hierarchy->vertex_order.size(), small->positions.size());
  EXPECT_EQ(builder.take().submesh, nullptr);
}

TEST(HierarchyBuilder, SeveralThreadsBuildTheSame) {
  HierarchyBuilder builder{3};
  std::vector<std::shared_ptr<const Submesh>> submeshes;
  for (std::uint32_t i = 0; i < 6; ++i) {
    submeshes.push_back(std::make_shared<const Submesh>(test::ball(12 + i)));
    builder.ask(submeshes.back());
  }
  builder.wait();
  std::size_t handed_over = 0;
  for (auto built = builder.take(); built.hierarchy; built = builder.take()) {
    EXPECT_EQ(built.hierarchy->triangles, build_hierarchy(*built.submesh).triangles);
    ++handed_over;
  }
  EXPECT_EQ(handed_over, submeshes.size());
}

TEST(HierarchyBuilder, PassesOverWhatNobodyHoldsAnyMore) {
  HierarchyBuilder builder{1};
  const auto first = std::make_shared<const Submesh>(test::hills(60));
  builder.ask(first);
  builder.ask(std::make_shared<const Submesh>(test::ball(20)));
  builder.wait();
  EXPECT_EQ(builder.take().submesh, first);
  EXPECT_EQ(builder.take().submesh, nullptr);
}

// That it ends at all, and soon, is what is tested.
TEST(HierarchyBuilder, EndsWithWorkLeft) {
  const auto submesh = std::make_shared<const Submesh>(test::hills(50));
  HierarchyBuilder builder{2};
  for (int i = 0; i < 30; ++i) builder.ask(submesh);
}

}  // namespace
}  // namespace meshloop
