#include "common/gpu/context.h"

#include <GLES3/gl31.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include "common/gpu/gl_objects.h"

namespace meshloop {
namespace {

TEST(GpuContext, IsMadeWithoutAWindow) {
  const auto context = GpuContext::create_headless();
  ASSERT_TRUE(context) << context.error().message;
  EXPECT_NE((*context)->description().find("OpenGL ES 3."), std::string::npos) << (*context)->description();
  GLint minor = 0;
  glGetIntegerv(GL_MINOR_VERSION, &minor);
  EXPECT_GE(minor, 1);
  EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
}

TEST(GpuContext, ComesBackAfterAnotherHasEnded) {
  for (int i = 0; i < 3; ++i) {
    const auto context = GpuContext::create_headless();
    ASSERT_TRUE(context) << context.error().message;
    const Texture texture = make_texture(GL_R32F, 8, 8);
    EXPECT_TRUE(glIsTexture(texture.name()));
  }
}

TEST(GpuContext, StaysUsableBesideAnother) {
  auto first = GpuContext::create_headless();
  ASSERT_TRUE(first);
  (*first)->make_current();
  const Buffer buffer;
  glBindBuffer(GL_ARRAY_BUFFER, buffer.name());
  {
    auto second = GpuContext::create_headless();
    ASSERT_TRUE(second);
    EXPECT_FALSE(glIsBuffer(buffer.name())) << "contexts share no objects";
  }
  (*first)->make_current();
  EXPECT_TRUE(glIsBuffer(buffer.name()));
}

TEST(GpuContext, SoftwareCanBeForced) {
  setenv("MESHLOOP_GPU", "software", 1);
  const auto context = GpuContext::create_headless();
  unsetenv("MESHLOOP_GPU");
  ASSERT_TRUE(context) << context.error().message;
  EXPECT_NE((*context)->description().find("pipe"), std::string::npos) << (*context)->description();
}

TEST(GpuContext, RefusesAnUnknownWish) {
  setenv("MESHLOOP_GPU", "fast", 1);
  const auto context = GpuContext::create_headless();
  unsetenv("MESHLOOP_GPU");
  ASSERT_FALSE(context);
  EXPECT_EQ(context.error().kind, ErrorKind::usage);
  EXPECT_NE(context.error().message.find("MESHLOOP_GPU=fast"), std::string::npos);
}

// In a process of its own, where no EGL driver can be found.
TEST(GpuContextDeathTest, NamesEachAttemptAndWhatToInstall) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto try_without_driver = [] {
    setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent/egl_vendor.json", 1);
    const auto context = GpuContext::create_headless();
    if (context) std::exit(0);
    std::fputs(context.error().message.c_str(), stderr);
    std::exit(exit_code(context.error().kind));
  };
  EXPECT_EXIT(try_without_driver(), testing::ExitedWithCode(3), "surfaceless: .*EGL error.*libegl1.*libgl1-mesa-dri");
}

TEST(Program, HandsOnTheCompilersWords) {
  const auto context = GpuContext::create_headless();
  ASSERT_TRUE(context);
  const auto broken = Program::create("#version 310 es\nvoid main() { nonsense; }", "#version 310 es\nvoid main() {}");
  ASSERT_FALSE(broken);
  EXPECT_NE(broken.error().message.find("vertex shader"), std::string::npos);
  EXPECT_NE(broken.error().message.find("nonsense"), std::string::npos);
}

TEST(Program, RefusesStagesThatDoNotFit) {
  const auto context = GpuContext::create_headless();
  ASSERT_TRUE(context);
  const auto program = Program::create("#version 310 es\nvoid main() { gl_Position = vec4(0.0); }",
                                       "#version 310 es\nprecision highp float;\nin vec2 missing;\nout vec4 "
                                       "color;\nvoid main() { color = missing.xyxy; }");
  ASSERT_FALSE(program);
  EXPECT_NE(program.error().message.find("link"), std::string::npos);
}

TEST(GlObject, MovesItsNameAndFreesItOnce) {
  const auto context = GpuContext::create_headless();
  ASSERT_TRUE(context);
  Texture first = make_texture(GL_R8UI, 4, 4);
  const GLuint name = first.name();
  Texture second = std::move(first);
  EXPECT_EQ(first.name(), 0U);  // NOLINT: the moved-from state is what is tested
  EXPECT_EQ(second.name(), name);
  second = make_texture(GL_R8UI, 4, 4);
  EXPECT_FALSE(glIsTexture(name));
  EXPECT_TRUE(glIsTexture(second.name()));
}

}  // namespace
}  // namespace meshloop
