#include "common/detail/hierarchy_builder.h"

#include <gtest/gtest.h>

#include "meshes.h"

namespace meshloop {
namespace {

std::vector<HierarchyBuilder::Built> all_of(HierarchyBuilder& builder) {
  std::vector<HierarchyBuilder::Built> all;
  while (builder.wait_for_next()) all.push_back(builder.take());
  return all;
}

TEST(HierarchyBuilder, HandsOverEachOnceInTheOrderOfAsking) {
  HierarchyBuilder builder{1, HierarchyBuilder::Priority::yielding};
  EXPECT_EQ(builder.take().hierarchy, nullptr);
  const auto small = std::make_shared<const Submesh>(test::ball(20));
  const auto large = std::make_shared<const Submesh>(test::hills(60));
  builder.ask(large);
  builder.ask(small);
  const auto built = all_of(builder);
  ASSERT_EQ(built.size(), 2u);
  EXPECT_EQ(built[0].submesh, large);
  EXPECT_EQ(built[1].submesh, small);
  EXPECT_EQ(built[1].hierarchy->vertex_order.size(), small->positions.size());
}

TEST(HierarchyBuilder, SeveralThreadsBuildTheSame) {
  HierarchyBuilder builder{3, HierarchyBuilder::Priority::normal};
  std::vector<std::shared_ptr<const Submesh>> submeshes;
  for (std::uint32_t i = 0; i < 6; ++i) {
    submeshes.push_back(std::make_shared<const Submesh>(test::ball(12 + i)));
    builder.ask(submeshes.back());
  }
  const auto all = all_of(builder);
  EXPECT_EQ(all.size(), submeshes.size());
  for (const auto& built : all) {
    EXPECT_EQ(built.hierarchy->triangles, build_hierarchy(*built.submesh).triangles);
  }
}

TEST(HierarchyBuilder, PassesOverWhatNobodyHoldsAnyMore) {
  HierarchyBuilder builder{1, HierarchyBuilder::Priority::normal};
  const auto first = std::make_shared<const Submesh>(test::hills(60));
  builder.ask(first);
  builder.ask(std::make_shared<const Submesh>(test::ball(20)));
  const auto all = all_of(builder);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].submesh, first);
}

// That it ends at all, and soon, is what is tested.
TEST(HierarchyBuilder, EndsWithWorkLeft) {
  const auto submesh = std::make_shared<const Submesh>(test::hills(50));
  HierarchyBuilder builder{2, HierarchyBuilder::Priority::normal};
  for (int i = 0; i < 30; ++i) builder.ask(submesh);
}

}  // namespace
}  // namespace meshloop
