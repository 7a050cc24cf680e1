#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "common/implicit/cast_ray.h"
#include "common/implicit/shape_file.h"
#include "common/implicit/tessellate.h"

namespace meshloop {
namespace {

using Eigen::Vector3d;

Shape solid(const std::string& text) {
  const auto shapes = parse_shapes("shapes:\n  - name: a\n    solid: " + text + "\n");
  EXPECT_TRUE(shapes) << shapes.error().message;
  return shapes ? shapes->front().shape : Shape{};
}

const char* const kEverything =
    "{union: [{difference: [{box: {size: [0.6, 0.5, 0.4]}}, {sphere: {radius: 0.27}},"
    " {transform: {translation: [0.1, 0, 0.3], axis: [1, 1, 0], angle_deg: 30, of: {cylinder: {radius: 0.1, height: "
    "1}}}}]},"
    " {transform: {translation: [0.5, 0, 0], axis: [0, 1, 0], angle_deg: 70, of: {torus: {radius: 0.2, tube: 0.05}}}},"
    " {transform: {translation: [-0.5, 0, 0], of: {intersection: [{cone: {radius: 0.2, height: 0.3}},"
    " {transform: {translation: [0, 0, 0.2], axis: [1, 0, 0], angle_deg: 20, of: {plane: }}}]}}}]}";

TEST(CastRay, MeetsASphereFromOutsideAndFromInside) {
  const Shape sphere = solid("{sphere: {radius: 0.5}}");
  const auto outside = cast_ray(sphere, {{0.3, 0, -3}, {0, 0, 1}}, 0.05, 50);
  ASSERT_TRUE(outside);
  EXPECT_NEAR(outside->t, 3 - 0.4, 1e-12);
  const auto inside = cast_ray(sphere, {{0.3, 0, 0}, {0, 0, 1}}, 0.05, 50);
  ASSERT_TRUE(inside);
  EXPECT_NEAR(inside->t, 0.4, 1e-12);
  EXPECT_FALSE(cast_ray(sphere, {{0.51, 0, -3}, {0, 0, 1}}, 0.05, 50));
  EXPECT_FALSE(cast_ray(sphere, {{0, 0, -3}, {0, 0, 1}}, 0.05, 2));
}

// Walks along each ray in small steps and looks whether it is inside: no formula of a root is used.
TEST(CastRay, AgreesWithWalkingAlongTheRay) {
  constexpr double kStep_m = 1e-3;
  constexpr double kAccuracy_m = 1e-7;
  std::mt19937 random{7};
  std::uniform_real_distribution<double> anywhere{-0.7, 0.7};
  for (const char* text : {"{box: {size: [0.4, 0.6, 0.8]}}", "{cylinder: {radius: 0.3, height: 0.7}}",
                           "{cone: {radius: 0.3, height: 0.7}}", "{torus: {radius: 0.4, tube: 0.15}}", kEverything}) {
    const Shape shape = solid(text);
    int hits = 0;
    for (int i = 0; i < 200; ++i) {
      const Vector3d from{anywhere(random), anywhere(random), anywhere(random)};
      const Vector3d direction = Vector3d{anywhere(random), anywhere(random), anywhere(random)}.normalized();
      const bool starts_inside = contains(shape, from);
      double walked = 0;
      while (walked < 3 && contains(shape, from + walked * direction) == starts_inside) walked += kStep_m;
      const bool met = walked < 3;
      for (double part = kStep_m / 2; met && part > kAccuracy_m / 4; part /= 2) {
        const double middle = walked - part;
        if (contains(shape, from + middle * direction) != starts_inside) walked = middle;
      }
      const auto hit = cast_ray(shape, {from, direction}, 0, 3);
      if (hit && hit->t < walked - kAccuracy_m) {
        // Thinner than a step: the surface must be there all the same.
        EXPECT_NE(contains(shape, from + (hit->t - 1e-6) * direction),
                  contains(shape, from + (hit->t + 1e-6) * direction))
            << text << " ray " << i;
        continue;
      }
      ASSERT_EQ(hit.has_value(), met) << text << " ray " << i;
      EXPECT_NEAR(hit ? hit->t : walked, walked, kAccuracy_m) << text << " ray " << i;
      hits += hit ? 1 : 0;
    }
    EXPECT_GT(hits, 10) << text;
  }
}

TEST(Shape, KnowsABoxAroundIt) {
  const auto bounds =
      bounds_of(solid("{transform: {translation: [1, 2, 3], of: {intersection: [{sphere: {radius: 1}}, {plane: }]}}}"));
  EXPECT_LT((bounds.min() - Vector3d(0, 1, 2)).norm(), 1e-12);
  EXPECT_LT((bounds.max() - Vector3d(2, 3, 3)).norm(), 1e-12);
}

TEST(ShapeFile, RefusesWhatItDoesNotKnowAndNamesTheLine) {
  const auto refusal = [](const std::string& text) {
    const auto shapes = parse_shapes("shapes:\n  - name: a\n    solid: " + text + "\n");
    return shapes ? std::string{"read"} : shapes.error().message;
  };
  const std::map<std::string, std::string> cases{
      {"{sphere: {radius: -1}}", "sizes"},
      {"{sphere: {radius: nan}}", "line 3: a number"},
      {"{sphere: {diameter: 1}}", "'diameter' is unknown"},
      {"{sphere: {}}", "'radius' is missing"},
      {"{cube: {size: [1, 1, 1]}}", "'cube' is no primitive"},
      {"{plane: }", "no end"},
      {"{union: [{sphere: {radius: 1}}]}", "at least two"},
      {"{torus: {radius: 0.1, tube: 0.2}}", "no hole"},
      {"{transform: {axis: [0, 0, 0], angle_deg: 3, of: {sphere: {radius: 1}}}}", "no direction"},
      {"{intersection: [{sphere: {radius: 1}}, {transform: {translation: [3, 0, 0], of: {sphere: {radius: 1}}}}]}",
       "empty"},
      {"{intersection: [{box: {size: [1, 1, 1]}}, {transform: {translation: [1, 1, 1], of: {box: {size: [1, 1, "
       "1]}}}}]}",
       "only touch"},
      {"{transform: {translation: [20000, 0, 0], of: {sphere: {radius: 1}}}}", "10 km"}};
  for (const auto& [text, expected] : cases)
    EXPECT_NE(refusal(text).find(expected), std::string::npos) << text << ": " << refusal(text);
  EXPECT_FALSE(parse_shapes("shapes: [[[["));
  EXPECT_FALSE(parse_shapes(""));
}

double volume(const Submesh& mesh) {
  double six = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    six +=
        mesh.positions[a].cast<double>().dot(mesh.positions[b].cast<double>().cross(mesh.positions[c].cast<double>()));
  }
  return six / 6;
}

TEST(Tessellate, KeepsEdgesSharpAndCurvedSurfacesNear) {
  const auto box = tessellate(solid("{box: {size: [0.4, 0.6, 0.8]}}"), 32);
  ASSERT_TRUE(box) << box.error().message;
  EXPECT_LT(box->error_m, 1e-5);
  EXPECT_NEAR(volume(box->submesh), 0.4 * 0.6 * 0.8, 1e-5);
  const auto sphere = tessellate(solid("{sphere: {radius: 0.5}}"), 64);
  ASSERT_TRUE(sphere) << sphere.error().message;
  EXPECT_LT(sphere->error_m, 5e-4);
  EXPECT_NEAR(volume(sphere->submesh), std::numbers::pi / 6, 1e-3);
  for (const auto& p : sphere->submesh.positions) EXPECT_NEAR(p.norm(), 0.5f, sphere->error_m + 1e-4);
}

TEST(Tessellate, StatesWhatFellBetweenThePointsOfItsGrid) {
  // A floor of 5 m, and a post of 2 m that is thinner than a cell.
  const auto mesh = tessellate(solid("{union: [{box: {size: [5, 5, 0.2]}}, {transform: {translation: [0.03, 0.02, 1], "
                                     "of: {cylinder: {radius: 0.01, height: 2}}}}]}"),
                               64);
  ASSERT_TRUE(mesh) << mesh.error().message;
  EXPECT_LT(mesh->submesh.bounds().max().z(), 0.2f);
  EXPECT_GT(mesh->error_m, 1.5);
}

TEST(Tessellate, StatesTheErrorOfADifference) {
  const auto mesh = tessellate(solid(kEverything), 32);
  ASSERT_TRUE(mesh) << mesh.error().message;
  EXPECT_TRUE(validate(mesh->submesh));
  EXPECT_GT(mesh->error_m, 0);
  EXPECT_LT(mesh->error_m, 0.05);
}

}  // namespace
}  // namespace meshloop
