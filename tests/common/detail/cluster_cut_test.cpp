#include "common/detail/cluster_cut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <numbers>
#include <random>
#include <utility>

#include "common/detail/simplify.h"
#include "meshes.h"
#include "sanitized.h"

namespace meshloop {
namespace {

/// Everything within 100 m on every side is in view, and w is the depth along z plus `ahead_m`. There is no eye, so
/// that either side of a closed part is shown.
Eigen::Matrix4f all_around(float ahead_m) {
  Eigen::Matrix4f clip = Eigen::Matrix4f::Zero();
  clip(0, 0) = clip(2, 2) = 0.001f;
  clip(3, 2) = 1;
  clip(3, 3) = ahead_m;
  return clip;
}

Tolerance everywhere(double tolerance_m) {
  return Tolerance{[=](double) { return tolerance_m; }};
}

/// The triangles that are chosen, in the submesh's vertices.
std::vector<Triangle> chosen(const ClusterHierarchy& hierarchy, const CutView& view) {
  ClusterCut cut;
  std::vector<Triangle> triangles;
  for (const auto& [first, count] : cut.choose(hierarchy, view)) {
    for (std::uint32_t t = first; t < first + count; ++t) {
      const auto& [a, b, c] = hierarchy.triangles[t];
      triangles.push_back({hierarchy.vertex_order[a], hierarchy.vertex_order[b], hierarchy.vertex_order[c]});
    }
  }
  return triangles;
}

std::vector<Triangle> chosen(const ClusterHierarchy& hierarchy, const Tolerance& tolerance) {
  CutView view;
  view.clip_from_mesh = all_around(2);
  view.tolerance = &tolerance;
  return chosen(hierarchy, view);
}

using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// How often each edge is run through in one direction more than in the other: the border of a surface.
std::map<Edge, int> border_of(const std::vector<Triangle>& triangles) {
  std::map<Edge, int> border;
  for (const auto& [a, b, c] : triangles) {
    for (const auto& [from, to] : {Edge{a, b}, Edge{b, c}, Edge{c, a}}) {
      border[std::minmax(from, to)] += from < to ? 1 : -1;
    }
  }
  std::erase_if(border, [](const auto& edge) { return edge.second == 0; });
  return border;
}

Deviation deviation_of(const Submesh& mesh, const std::vector<Triangle>& shown) {
  constexpr std::size_t kEvery = test::kSanitized ? 997 : 31;
  float largest = 0;
  float sum = 0;
  std::size_t count = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); v += kEvery) {
    float nearest = 1e9f;
    for (const auto& [a, b, c] : shown) {
      nearest = std::min(nearest,
                         squared_distance(mesh.positions[v], mesh.positions[a], mesh.positions[b], mesh.positions[c]));
    }
    largest = std::max(largest, nearest);
    sum += nearest;
    ++count;
  }
  return {std::sqrt(largest), std::sqrt(sum / static_cast<float>(count))};
}

std::vector<Triangle> sorted(std::vector<Triangle> triangles) {
  for (auto& triangle : triangles) std::rotate(triangle.begin(), std::ranges::min_element(triangle), triangle.end());
  std::ranges::sort(triangles);
  return triangles;
}

TEST(ClusterCut, ExactIsEveryTriangleOnce) {
  for (const auto& mesh : {test::hills(100), test::ball(60)}) {
    EXPECT_EQ(sorted(chosen(build_hierarchy(mesh), Tolerance{})), sorted(mesh.triangles));
  }
}

TEST(ClusterCut, LessDetailIsFewerTrianglesWithinTheTolerance) {
  for (const auto& [mesh, least_gain] : {std::pair{test::hills(200), 60U}, std::pair{test::ball(100), 20U}}) {
    const auto hierarchy = build_hierarchy(mesh);
    std::size_t finer = mesh.triangles.size();
    for (const double tolerance_m : {0.0002, 0.001, 0.005}) {
      const auto shown = chosen(hierarchy, everywhere(tolerance_m));
      EXPECT_LT(shown.size(), finer);
      const auto [largest_m, rms_m] = deviation_of(mesh, shown);
      EXPECT_LE(rms_m, tolerance_m);
      EXPECT_LE(largest_m, kLargestPerError * tolerance_m);
      std::printf("tolerance %.1f mm: %zu of %zu triangles, root mean square %.2f of it, largest %.2f\n",
                  1000 * tolerance_m, shown.size(), mesh.triangles.size(), rms_m / tolerance_m,
                  largest_m / tolerance_m);
      finer = shown.size();
    }
    EXPECT_LT(finer, mesh.triangles.size() / least_gain);
  }
}

TEST(ClusterHierarchy, ErrorsAndBoxesGrowUpwards) {
  for (const auto& mesh : {test::hills(200), test::ball(100)}) {
    const auto hierarchy = build_hierarchy(mesh);
    ASSERT_GT(hierarchy.groups.size(), 10U);
    for (const auto& group : hierarchy.groups) {
      for (std::uint32_t m = group.first_member; m < group.first_member + group.member_count; ++m) {
        const Cluster& member = hierarchy.clusters[hierarchy.members[m]];
        EXPECT_TRUE(group.bounds.contains(member.bounds));
        if (member.made_by == Cluster::kNone) continue;
        const ClusterGroup& earlier = hierarchy.groups[static_cast<std::size_t>(member.made_by)];
        EXPECT_GE(group.error_m, earlier.error_m);
        EXPECT_TRUE(group.bounds.contains(earlier.bounds));
      }
    }
  }
}

TEST(ClusterCut, NoCrackOpensWhereDetailChanges) {
  const auto open = test::hills(200);
  const auto closed = test::ball(100);
  std::mt19937 random{1};
  std::uniform_real_distribution<double> share{0.0, 1.0};
  for (const auto* mesh : {&open, &closed}) {
    const auto hierarchy = build_hierarchy(*mesh);
    const auto border = border_of(mesh->triangles);
    for (int i = 0; i < 20; ++i) {
      const double slope = 0.02 * share(random) * share(random);
      const double start_m = 3 * share(random);
      const Tolerance tolerance{[=](double z_m) { return slope * std::max(0.0, z_m - start_m); }};
      CutView view;
      view.clip_from_mesh = all_around(2.2f);
      view.clip_from_mesh(3, 0) = static_cast<float>(share(random));
      view.tolerance = &tolerance;
      EXPECT_EQ(border_of(chosen(hierarchy, view)), border) << "slope " << slope << " from " << start_m;
    }
  }
}

TEST(ClusterCut, WhatLiesBesideTheViewIsLeftOut) {
  const auto mesh = test::hills(200);
  const auto hierarchy = build_hierarchy(mesh);
  // A box around the quarter x, y > 0.
  Eigen::Matrix4f clip = Eigen::Matrix4f::Identity();
  clip(0, 0) = clip(1, 1) = 2;
  clip(0, 3) = clip(1, 3) = -1;
  const Tolerance exact;
  CutView view;
  view.clip_from_mesh = clip;
  view.tolerance = &exact;
  const auto shown = chosen(hierarchy, view);
  std::size_t inside = 0;
  for (const auto& triangle : mesh.triangles) {
    inside +=
        std::ranges::all_of(triangle, [&](std::uint32_t v) { return mesh.positions[v].head<2>().minCoeff() >= 0; }) ? 1
                                                                                                                    : 0;
  }
  EXPECT_GE(shown.size(), inside);
  EXPECT_LT(shown.size(), inside + mesh.triangles.size() / 8);
}

/// A camera on the z axis that looks along it with a view of 90 degrees, from 0.1 m on.
Eigen::Matrix4f seen_from(float z_m) {
  Eigen::Matrix4f clip = Eigen::Matrix4f::Zero();
  clip(0, 0) = clip(1, 1) = 1;
  clip(2, 2) = 1;
  clip(2, 3) = -z_m - 0.2f;
  clip(3, 2) = 1;
  clip(3, 3) = -z_m;
  return clip;
}

/// How many triangles that show their front to a point on the z axis are left out, and how many in all.
struct LeftOut {
  std::size_t fronts = 0;
  std::size_t all = 0;
};

LeftOut left_out(const Submesh& mesh, const Eigen::Matrix4f& clip, const Tolerance& tolerance, float eye_z_m) {
  CutView view;
  view.clip_from_mesh = clip;
  view.tolerance = &tolerance;
  const auto all = sorted(mesh.triangles);
  const auto shown = sorted(chosen(build_hierarchy(mesh), view));
  EXPECT_TRUE(std::ranges::includes(all, shown));
  LeftOut result;
  for (const auto& triangle : all) {
    if (std::ranges::binary_search(shown, triangle)) continue;
    const Eigen::Vector3f to_eye = Eigen::Vector3f{0, 0, eye_z_m} - mesh.positions[triangle[0]];
    result.fronts += normal_of(mesh.positions, triangle).dot(to_eye) > 0 ? 1 : 0;
    ++result.all;
  }
  return result;
}

/// So little that no level but the finest keeps to it, yet not exact.
const Tolerance kFinest = everywhere(1e-9);

TEST(ClusterCut, TheFarSideOfAClosedPartIsLeftOut) {
  const auto mesh = test::ball(60);
  const auto [fronts, all] = left_out(mesh, seen_from(-4), kFinest, -4);
  EXPECT_EQ(fronts, 0U);
  EXPECT_GT(all, mesh.triangles.size() / 3);
}

TEST(ClusterCut, WhatMayBeSeenFromBehindIsShown) {
  const auto ball = test::ball(60);
  Submesh holed = ball;
  holed.triangles.pop_back();
  for (const auto& mesh : {holed, test::inside_out(ball), test::hills(60)}) {
    EXPECT_EQ(left_out(mesh, seen_from(-4), kFinest, -4).all, 0U);
  }
  EXPECT_EQ(left_out(ball, seen_from(-4), Tolerance{}, -4).all, 0U) << "every triangle was asked for";
  EXPECT_EQ(left_out(ball, all_around(2), kFinest, -4).all, 0U) << "there is no eye";
  Eigen::Matrix4f parallel = Eigen::Matrix4f::Identity();
  parallel.topLeftCorner<3, 3>() *= 0.1f;
  EXPECT_EQ(left_out(ball, parallel, kFinest, -4).all, 0U);
}

bool is_in_view(const Eigen::Matrix4f& clip, const Eigen::Vector3f& p) {
  const Eigen::Vector4f seen = clip * p.homogeneous();
  return seen.head<3>().cwiseAbs().maxCoeff() < seen.w();
}

TEST(ClusterCut, AClosedPartIsShownWholeFromInsideAndThroughTheNearPlane) {
  const auto ball = test::ball(60);
  const auto hierarchy = build_hierarchy(ball);
  for (const float eye_z_m : {0.0f, -1.05f}) {
    CutView view;
    view.clip_from_mesh = seen_from(eye_z_m);
    view.tolerance = &kFinest;
    const auto shown = sorted(chosen(hierarchy, view));
    std::size_t in_view = 0;
    for (const auto& triangle : sorted(ball.triangles)) {
      if (!std::ranges::any_of(triangle, [&](auto v) { return is_in_view(view.clip_from_mesh, ball.positions[v]); })) {
        continue;
      }
      ++in_view;
      EXPECT_TRUE(std::ranges::binary_search(shown, triangle));
    }
    EXPECT_GT(in_view, ball.triangles.size() / 20);
  }
}

TEST(ClusterCut, APartThatTouchesAnotherAtACornerFacesItsOwnWay) {
  // Two balls with one vertex in common, the second inside out: not one triangle of that one may be missing.
  const auto ball = test::ball(40);
  auto touching = test::inside_out(ball);
  for (auto& p : touching.positions) p.z() += 2;
  auto both = test::beside(ball, touching, 0);
  const auto top = static_cast<std::uint32_t>(ball.positions.size() + touching.positions.size() - 1);
  ASSERT_EQ(both.positions[top], both.positions[0]);
  const Eigen::Matrix4f clip = seen_from(-5);
  CutView view;
  view.clip_from_mesh = clip;
  view.tolerance = &kFinest;
  const auto shown = sorted(chosen(build_hierarchy(both), view));
  EXPECT_LT(shown.size(), both.triangles.size() * 5 / 6);
  const std::vector<Triangle> second(both.triangles.begin() + static_cast<std::ptrdiff_t>(ball.triangles.size()),
                                     both.triangles.end());
  EXPECT_TRUE(std::ranges::includes(shown, sorted(second)));
}

TEST(ClusterCut, APartThatIsTurnedOverInPlacesIsShownWhole) {
  // Rings whose section is an eight, upright or lying: they pass through themselves, and one lobe is inside out.
  constexpr std::uint32_t kAlong = 200;
  constexpr std::uint32_t kAround = 60;
  const auto at = [](std::uint32_t i, std::uint32_t k) { return i % kAlong * kAround + k % kAround; };
  for (const bool is_upright : {true, false}) {
    Submesh ring;
    for (std::uint32_t i = 0; i < kAlong; ++i) {
      const float along = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / kAlong;
      for (std::uint32_t k = 0; k < kAround; ++k) {
        const float around = 2 * std::numbers::pi_v<float> * static_cast<float>(k) / kAround;
        const float lobes = 0.3f * std::sin(around);
        const float waist = 0.2f * std::sin(2 * around);
        const float r = 0.8f + (is_upright ? waist : lobes);
        ring.positions.emplace_back(r * std::cos(along), r * std::sin(along), is_upright ? lobes : waist);
      }
    }
    for (std::uint32_t i = 0; i < kAlong; ++i) {
      for (std::uint32_t k = 0; k < kAround; ++k) {
        ring.triangles.push_back({at(i, k), at(i + 1, k), at(i, k + 1)});
        ring.triangles.push_back({at(i, k + 1), at(i + 1, k), at(i + 1, k + 1)});
      }
    }
    EXPECT_EQ(left_out(ring, seen_from(-4), kFinest, -4).all, 0U);
    EXPECT_EQ(left_out(test::inside_out(ring), seen_from(-4), kFinest, -4).all, 0U);
  }
}

TEST(ClusterCut, EachPartIsClosedForItself) {
  const auto ball = test::ball(60);
  Submesh holed = ball;
  holed.triangles.erase(holed.triangles.begin());
  const auto alone = left_out(ball, seen_from(-4), kFinest, -4).all;
  EXPECT_EQ(left_out(test::beside(ball, test::ball(30), 2), seen_from(-8), kFinest, -8).fronts, 0U);
  // A cluster may hold triangles of both, so a few more are shown.
  const auto with_open = left_out(test::beside(ball, holed, 0.5f), seen_from(-4), kFinest, -4).all;
  EXPECT_GT(with_open, alone * 9 / 10);
  EXPECT_LE(with_open, alone);
}

TEST(Tolerance, IsNeverMoreThanAskedForAtAnyFartherDepth) {
  const auto dip = [](double z_m) { return z_m < 3 ? 0.01 : 0.002 * z_m; };
  const Tolerance tolerance{dip};
  for (double z = 0; z < 19; z += 0.013) {
    for (double farther = z; farther < 20; farther += 0.1) {
      EXPECT_LE(tolerance.at(static_cast<float>(z)), dip(farther) * 1.00001);
    }
  }
  EXPECT_GT(tolerance.at(2.9f), 0.005f);
  EXPECT_EQ(tolerance.at(-1), tolerance.at(0));
  EXPECT_EQ(Tolerance{}.at(1), 0);
}

}  // namespace
}  // namespace meshloop
