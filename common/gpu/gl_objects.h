#pragma once
// GL names that free themselves. All of them are made, used and destroyed while the context that they belong to is
// current on the calling thread (GpuContext::make_current). A moved-from object holds the name 0, which GL ignores.
#include <GLES3/gl31.h>

#include <string_view>
#include <utility>

#include "common/base/result.h"

namespace meshloop {

/// Owns one GL name from its construction to its end. Kind says how names are made and freed.
template <class Kind>
class GlObject {
 public:
  GlObject() : name_{Kind::make()} {}
  ~GlObject() { free(); }
  GlObject(GlObject&& other) noexcept : name_{std::exchange(other.name_, 0U)} {}
  GlObject& operator=(GlObject&& other) noexcept {
    if (this != &other) {
      free();
      name_ = std::exchange(other.name_, 0U);
    }
    return *this;
  }
  GlObject(const GlObject&) = delete;
  GlObject& operator=(const GlObject&) = delete;

  [[nodiscard]] GLuint name() const { return name_; }

 private:
  void free() {
    if (name_ != 0) Kind::free(name_);
  }
  GLuint name_;
};

struct BufferKind {
  static GLuint make();
  static void free(GLuint name);
};
struct TextureKind {
  static GLuint make();
  static void free(GLuint name);
};
struct FramebufferKind {
  static GLuint make();
  static void free(GLuint name);
};
struct VertexArrayKind {
  static GLuint make();
  static void free(GLuint name);
};

using Buffer = GlObject<BufferKind>;
using Texture = GlObject<TextureKind>;
using Framebuffer = GlObject<FramebufferKind>;
using VertexArray = GlObject<VertexArrayKind>;

/// A texture with storage that never changes, read without filtering and clamped at its edges.
[[nodiscard]] Texture make_texture(GLenum internal_format, int width, int height);

/// A linked shader program.
class Program {
 public:
  /// GLSL ES sources, `#version` line included. A failure is the compiler's or the linker's own words.
  [[nodiscard]] static Result<Program> create(std::string_view vertex, std::string_view fragment);

  ~Program();
  Program(Program&& other) noexcept : name_{std::exchange(other.name_, 0U)} {}
  Program& operator=(Program&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  [[nodiscard]] GLuint name() const { return name_; }
  void use() const { glUseProgram(name_); }

 private:
  explicit Program(GLuint name) : name_{name} {}
  GLuint name_;
};

/// Refuses when the framebuffer that is bound to GL_FRAMEBUFFER cannot be drawn to; `what` names it in the message.
[[nodiscard]] Status check_framebuffer(std::string_view what);

/// The pixels of one colour attachment of the framebuffer, as one channel each; the context's read framebuffer becomes
/// `framebuffer`. For attachments of R32F, and of R32UI. Waits for the drawing. `pixels` has width * height
/// elements.
void read_floats(const Framebuffer& framebuffer, GLenum attachment, int width, int height, float* pixels);
void read_unsigned(const Framebuffer& framebuffer, GLenum attachment, int width, int height, GLuint* pixels);
/// Of R8UI.
void read_bytes(const Framebuffer& framebuffer, GLenum attachment, int width, int height, GLubyte* pixels);

}  // namespace meshloop
