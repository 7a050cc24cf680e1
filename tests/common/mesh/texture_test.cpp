#include "common/mesh/texture.h"

#include <gtest/gtest.h>

#include <limits>

#include "common/mesh/submesh.h"
#include "textured_wall.h"

namespace meshloop {
namespace {

using test::must_project;
using test::projection_of;
using test::projector_camera;
using test::projector_pose;
using test::smooth_picture;
using test::textured_wall;

/// The wall with something about its texture changed.
template <class Change>
Submesh changed_wall(Change change) {
  Submesh wall = textured_wall();
  auto texture = std::make_shared<ProjectedTexture>(*wall.texture);
  change(*texture);
  wall.texture = std::move(texture);
  return wall;
}

std::string refusal(const Submesh& submesh) {
  const auto ok = validate(submesh);
  return ok ? std::string{} : ok.error().message;
}

int largest_difference(const Rgb8& a, const Rgb8& b) {
  return std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
}

TEST(ProjectedTexture, AWallWithOneIsValid) {
  EXPECT_EQ(refusal(textured_wall()), "");
}

TEST(ProjectedTexture, PixelsAreThoseOfTheCameraThatTookIt) {
  const Camera camera = projector_camera();
  const auto texture = must_project(smooth_picture(160, 120), projection_of(camera, projector_pose()));
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d{0, 0}, {159, 119}, {31.25, 80.5}}) {
    const Eigen::Vector3d p = projector_pose().inverse() * camera.back_project(pixel.x(), pixel.y(), 1.75);
    EXPECT_LT((pixel_of(*texture, p.cast<float>()).cast<double>() - pixel).norm(), 1e-3);
  }
}

TEST(ProjectedTexture, PixelCentresHaveIntegerCoordinates) {
  ColorImage picture{3, 2};
  picture(0, 0) = {10, 20, 30};
  picture(1, 0) = {50, 60, 70};
  picture(0, 1) = {90, 0, 200};
  EXPECT_EQ(bilinear(picture, {0, 0}), (Rgb8{10, 20, 30}));
  EXPECT_EQ(bilinear(picture, {1, 0}), (Rgb8{50, 60, 70}));
  EXPECT_EQ(bilinear(picture, {0.25F, 0}), (Rgb8{20, 30, 40}));
  EXPECT_EQ(bilinear(picture, {0, 0.5F}), (Rgb8{50, 10, 115}));
}

TEST(ProjectedTexture, GoesOnBeyondItsBorders) {
  const ColorImage picture = smooth_picture(5, 4);
  EXPECT_EQ(bilinear(picture, {-3, -100}), picture(0, 0));
  EXPECT_EQ(bilinear(picture, {1e9F, 1e9F}), picture(4, 3));
  EXPECT_EQ(bilinear(ColorImage{1, 1, {1, 2, 3}}, {0.5F, 0.5F}), (Rgb8{1, 2, 3}));
}

TEST(ProjectedTexture, ColorsOfVerticesAreThoseOfThePaintedPicture) {
  const Submesh wall = textured_wall();
  const Camera camera = projector_camera();
  const ColorImage painted = smooth_picture(camera.width, camera.height);
  const auto colors = vertex_colors(wall);
  ASSERT_TRUE(colors) << colors.error().message;
  ASSERT_EQ(colors->size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d pixel = camera.project(projector_pose() * wall.positions[i].cast<double>());
    ASSERT_TRUE(camera.contains(pixel, 1)) << pixel.transpose();
    EXPECT_LE(largest_difference((*colors)[i], bilinear(painted, pixel.cast<float>())), 6);
  }
}

TEST(ProjectedTexture, EachPartOfItIsInTheHash) {
  const Hash hash = content_hash(textured_wall());
  EXPECT_EQ(content_hash(textured_wall()), hash);
  Submesh plain = textured_wall();
  plain.texture = nullptr;
  EXPECT_NE(content_hash(plain), hash);
  EXPECT_NE(content_hash(changed_wall([](auto& texture) { texture.jpeg.back() ^= std::byte{1}; })), hash);
  EXPECT_NE(content_hash(changed_wall([](auto& texture) { texture.projection(1, 3) += 0.001F; })), hash);
}

TEST(ProjectedTexture, AHashWithoutOneIsWhatItWas) {
  // Scene files of earlier versions hold it.
  const Submesh triangle{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5F}}, {}, {{0, 1, 2}}};
  EXPECT_EQ(to_hex(content_hash(triangle)), "b785caa5472bd7ee28100eda671e95e09e7b4a4d06e5b1d16105c1b3b1b92ba9");
}

TEST(ProjectedTexture, CountsItsPixelsAsRawBytes) {
  Submesh wall = textured_wall();
  const std::size_t with = wall.raw_bytes();
  wall.texture = nullptr;
  EXPECT_EQ(with - wall.raw_bytes(), 160u * 120u * 3u);
}

TEST(ProjectedTexture, RefusesColorsBesideIt) {
  Submesh wall = textured_wall();
  wall.colors.resize(4);
  EXPECT_NE(refusal(wall).find("one of them"), std::string::npos) << refusal(wall);
}

TEST(ProjectedTexture, RefusesAPictureOfAnotherSizeThanStated) {
  const auto wall = changed_wall([](auto& texture) { ++texture.width; });
  EXPECT_NE(refusal(wall).find("160 x 120 pixels, not 161 x 120"), std::string::npos) << refusal(wall);
}

TEST(ProjectedTexture, RefusesWhatIsNoJpeg) {
  EXPECT_FALSE(validate(changed_wall([](auto& texture) { texture.jpeg.clear(); })));
  EXPECT_FALSE(validate(changed_wall([](auto& texture) { texture.jpeg.resize(20); })));
  EXPECT_FALSE(validate(changed_wall([](auto& texture) { texture.jpeg[0] = std::byte{0}; })));
}

TEST(ProjectedTexture, RefusesSidesThatNotEveryDeviceCanHold) {
  const TextureProjection projection = projection_of(projector_camera(), projector_pose());
  EXPECT_TRUE(make_projected_texture(encode_jpeg(ColorImage{kLargestTextureSide, 1}, 50).value(), projection));
  EXPECT_FALSE(make_projected_texture(encode_jpeg(ColorImage{kLargestTextureSide + 1, 1}, 50).value(), projection));
  EXPECT_FALSE(make_projected_texture(encode_jpeg(ColorImage{1, kLargestTextureSide + 1}, 50).value(), projection));
}

TEST(ProjectedTexture, RefusesMoreBytesThanCanBeSentWithANode) {
  const auto wall = changed_wall([](auto& texture) { texture.jpeg.resize(kMostTextureBytes + 1); });
  EXPECT_NE(refusal(wall).find("at most"), std::string::npos) << refusal(wall);
}

TEST(ProjectedTexture, RefusesAProjectionThatIsNotFinite) {
  for (const float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    EXPECT_FALSE(validate(changed_wall([=](auto& texture) { texture.projection(0, 2) = value; })));
  }
}

TEST(ProjectedTexture, RefusesPointsBehindItsCamera) {
  Submesh wall = textured_wall();
  const Pose T_node_camera = projector_pose().inverse();
  wall.positions[2] = (T_node_camera * Eigen::Vector3d{0, 0, -0.5}).cast<float>();
  EXPECT_NE(refusal(wall).find("behind"), std::string::npos) << refusal(wall);
  // In the camera's own plane there is no pixel either.
  EXPECT_FALSE(validate(changed_wall([](auto& texture) { texture.projection.row(2).setZero(); })));
}

TEST(ProjectedTexture, IsSharedByWhatIsLeftOfASurface) {
  const Submesh wall = textured_wall();
  const Submesh left = keep_triangles(wall, {true, false});
  EXPECT_EQ(left.texture, wall.texture);
  EXPECT_EQ(snap_to_lattice(wall, 4).texture, wall.texture);
}

TEST(ProjectedTexture, ADamagedPictureHasNoColors) {
  const auto wall = changed_wall([](auto& texture) { texture.jpeg.resize(texture.jpeg.size() / 2); });
  EXPECT_EQ(refusal(wall), "");  // the header is whole
  EXPECT_FALSE(vertex_colors(wall));
}

}  // namespace
}  // namespace meshloop
