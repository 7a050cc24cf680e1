#include "common/gpu/image_upload.h"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "common/gpu/context.h"

namespace meshloop {
namespace {

Image<float> numbered(int width, int height, float first) {
  Image<float> image(width, height);
  std::iota(image.pixels().begin(), image.pixels().end(), first);
  return image;
}

std::vector<float> values_of(const Image<float>& image) {
  return {image.pixels().begin(), image.pixels().end()};
}

std::vector<float> content_of(const Texture& texture, int width, int height) {
  const Framebuffer framebuffer;
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture.name(), 0);
  std::vector<float> rgba(static_cast<std::size_t>(4 * width * height));
  glReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, rgba.data());
  std::vector<float> red;
  for (std::size_t i = 0; i < rgba.size(); i += 4) red.push_back(rgba[i]);
  return red;
}

class ImageUploadTest : public testing::TestWithParam<UploadPath> {
 protected:
  void SetUp() override {
    auto context = GpuContext::create_headless();
    ASSERT_TRUE(context) << context.error().message;
    context_ = std::move(*context);
  }
  std::unique_ptr<GpuContext> context_;
};

TEST_P(ImageUploadTest, BringsEachImageWholeAlsoWhenSizesChange) {
  ImageUpload upload{GetParam()};
  for (const auto& [width, height] : {std::pair{64, 48}, std::pair{64, 48}, std::pair{176, 144}, std::pair{17, 5}}) {
    const Texture first = make_texture(GL_R32F, width, height);
    const Texture second = make_texture(GL_R32F, width, height);
    // More than there are buffers, before anything is read.
    for (int i = 0; i < 5; ++i) {
      upload.fill(first, numbered(width, height, static_cast<float>(i)));
      upload.fill(second, numbered(width, height, static_cast<float>(100 + i)));
    }
    EXPECT_EQ(content_of(first, width, height), values_of(numbered(width, height, 4)));
    EXPECT_EQ(content_of(second, width, height), values_of(numbered(width, height, 104)));
    EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
  }
}

INSTANTIATE_TEST_SUITE_P(Paths, ImageUploadTest,
                         testing::Values(UploadPath::by_driver, UploadPath::direct, UploadPath::buffers));

TEST(ImageUpload, TakesTheDirectPathInSoftware) {
  const auto context = GpuContext::create_headless();
  ASSERT_TRUE(context) << context.error().message;
  EXPECT_FALSE(ImageUpload{UploadPath::direct}.uses_buffers());
  if ((*context)->description().find("llvmpipe") == std::string::npos) GTEST_SKIP() << "drawn by hardware";
  EXPECT_FALSE(ImageUpload{UploadPath::by_driver}.uses_buffers());
  EXPECT_TRUE(ImageUpload{UploadPath::buffers}.uses_buffers());
}

}  // namespace
}  // namespace meshloop
