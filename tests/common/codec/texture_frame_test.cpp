#include "common/codec/texture_frame.h"

#include <gtest/gtest.h>

#include "common/codec/mesh_codec.h"
#include "meshes.h"
#include "textured_wall.h"

namespace meshloop {
namespace {

using test::textured_wall;

TEST(TextureFrame, BringsMeshAndTextureBackBitForBit) {
  const Submesh wall = textured_wall();
  const auto bytes = encode(wall);
  ASSERT_TRUE(bytes) << bytes.error().message;
  const auto decoded = decode(*bytes);
  ASSERT_TRUE(decoded) << decoded.error().message;
  ASSERT_TRUE(decoded->texture);
  EXPECT_EQ(decoded->texture->jpeg, wall.texture->jpeg);
  EXPECT_EQ(decoded->texture->projection, wall.texture->projection);
  EXPECT_EQ(decoded->texture->width, 160);
  EXPECT_EQ(decoded->texture->height, 120);
  EXPECT_FALSE(decoded->has_colors());
  EXPECT_TRUE(test::faces_of(*decoded) == test::faces_of(wall));
}

TEST(TextureFrame, AddsNothingToPayloadsWithoutOne) {
  const auto bytes = encode(test::depth_grid(20, 10)).value();
  EXPECT_FALSE(is_texture_frame(bytes));
  EXPECT_EQ(static_cast<char>(bytes[0]), 'D');
}

TEST(TextureFrame, IsRefusedWhereverItIsCut) {
  const auto bytes = encode(textured_wall()).value();
  for (std::size_t size = 0; size < bytes.size(); size += size < 200 ? 1 : 97) {
    EXPECT_FALSE(decode(std::span{bytes}.first(size))) << size;
  }
}

TEST(TextureFrame, IsRefusedWithADamagedPictureWhoseHeaderIsWhole) {
  const auto wall = textured_wall();
  const auto bytes = encode(wall).value();
  const auto cut = std::span{bytes}.first(bytes.size() - wall.texture->jpeg.size() / 2);
  EXPECT_TRUE(split_texture_frame(cut));
  const auto decoded = decode(cut);
  ASSERT_FALSE(decoded);
  EXPECT_NE(decoded.error().message.find("texture"), std::string::npos) << decoded.error().message;
}

TEST(TextureFrame, IsRefusedWithALengthBeyondItsEnd) {
  auto bytes = encode(textured_wall()).value();
  for (std::size_t i = 4; i < 8; ++i) bytes[i] = std::byte{0xff};
  EXPECT_FALSE(split_texture_frame(bytes));
  EXPECT_FALSE(decode(bytes));
}

TEST(TextureFrame, IsRefusedWithAProjectionThatDoesNotSeeTheMesh) {
  auto bytes = encode(textured_wall()).value();
  const auto frame = split_texture_frame(bytes);
  ASSERT_TRUE(frame);
  ProjectedTexture turned = *textured_wall().texture;
  turned.projection = -turned.projection;  // the same pixels, from behind
  EXPECT_FALSE(decode(join_texture_frame(frame->mesh, turned)));
  turned.projection = -turned.projection;
  EXPECT_TRUE(decode(join_texture_frame(frame->mesh, turned)));
}

TEST(TextureFrame, CountsAgainstTheLimitOfBytes) {
  const auto bytes = encode(textured_wall()).value();
  EXPECT_TRUE(decode(bytes, {.max_bytes = bytes.size()}));
  EXPECT_FALSE(decode(bytes, {.max_bytes = bytes.size() - 1}));
}

}  // namespace
}  // namespace meshloop
