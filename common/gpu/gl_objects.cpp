#include "common/gpu/gl_objects.h"

#include <fmt/format.h>

#include <algorithm>

#include <array>
#include <string>
#include <vector>

namespace meshloop {
namespace {

std::string shader_log(GLuint shader) {
  GLint length = 0;
  glGetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
  std::string text(static_cast<std::size_t>(length > 0 ? length : 1), '\0');
  glGetShaderInfoLog(shader, static_cast<GLsizei>(text.size()), nullptr, text.data());
  return text.c_str();
}

std::string program_log(GLuint program) {
  GLint length = 0;
  glGetProgramiv(program, GL_INFO_LOG_LENGTH, &length);
  std::string text(static_cast<std::size_t>(length > 0 ? length : 1), '\0');
  glGetProgramInfoLog(program, static_cast<GLsizei>(text.size()), nullptr, text.data());
  return text.c_str();
}

// Compiles a shader and attaches it; the program keeps it alive until the program's own end.
Status attach(GLuint program, GLenum stage, std::string_view stage_name, std::string_view source) {
  const GLuint shader = glCreateShader(stage);
  const char* text = source.data();
  const auto length = static_cast<GLint>(source.size());
  glShaderSource(shader, 1, &text, &length);
  glCompileShader(shader);
  GLint compiled = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (compiled == GL_FALSE) {
    const std::string log = shader_log(shader);
    glDeleteShader(shader);
    return fail(fmt::format("the {} shader does not compile: {}", stage_name, log));
  }
  glAttachShader(program, shader);
  glDeleteShader(shader);
  return {};
}

Status link(GLuint program) {
  glLinkProgram(program);
  GLint linked = GL_FALSE;
  glGetProgramiv(program, GL_LINK_STATUS, &linked);
  if (linked == GL_FALSE) return fail("the shader program does not link: " + program_log(program));
  return {};
}

// GLES guarantees four channels; fewer are what the driver may offer beside them, and usually does.
bool offers(GLenum format, GLenum type) {
  GLint offered_format = 0;
  GLint offered_type = 0;
  glGetIntegerv(GL_IMPLEMENTATION_COLOR_READ_FORMAT, &offered_format);
  glGetIntegerv(GL_IMPLEMENTATION_COLOR_READ_TYPE, &offered_type);
  return static_cast<GLenum>(offered_format) == format && static_cast<GLenum>(offered_type) == type;
}

struct ReadFormat {
  GLenum format;
  GLenum four_channels;
  GLenum type;
};

void bind_for_reading(const Framebuffer& framebuffer, GLenum attachment) {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer.name());
  glReadBuffer(attachment);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
}

template <class T>
void read_channel(const Framebuffer& framebuffer, GLenum attachment, int width, int height, const ReadFormat& format,
                  T* pixels) {
  bind_for_reading(framebuffer, attachment);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  if (offers(format.format, format.type)) {
    glReadPixels(0, 0, width, height, format.format, format.type, pixels);
    return;
  }
  const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  std::vector<T> wide(4 * count);
  glReadPixels(0, 0, width, height, format.four_channels, format.type, wide.data());
  for (std::size_t i = 0; i < count; ++i) pixels[i] = wide[4 * i];
}

}  // namespace

GLuint BufferKind::make() {
  GLuint name = 0;
  glGenBuffers(1, &name);
  return name;
}
void BufferKind::free(GLuint name) {
  glDeleteBuffers(1, &name);
}

GLuint TextureKind::make() {
  GLuint name = 0;
  glGenTextures(1, &name);
  return name;
}
void TextureKind::free(GLuint name) {
  glDeleteTextures(1, &name);
}

GLuint FramebufferKind::make() {
  GLuint name = 0;
  glGenFramebuffers(1, &name);
  return name;
}
void FramebufferKind::free(GLuint name) {
  glDeleteFramebuffers(1, &name);
}

GLuint VertexArrayKind::make() {
  GLuint name = 0;
  glGenVertexArrays(1, &name);
  return name;
}
void VertexArrayKind::free(GLuint name) {
  glDeleteVertexArrays(1, &name);
}

Texture make_texture(GLenum internal_format, int width, int height) {
  Texture texture;
  glBindTexture(GL_TEXTURE_2D, texture.name());
  glTexStorage2D(GL_TEXTURE_2D, 1, internal_format, width, height);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return texture;
}

Result<Program> Program::create(std::string_view vertex, std::string_view fragment) {
  Program program{glCreateProgram()};
  if (auto done = attach(program.name_, GL_VERTEX_SHADER, "vertex", vertex); !done) return fail(done.error());
  if (auto done = attach(program.name_, GL_FRAGMENT_SHADER, "fragment", fragment); !done) return fail(done.error());
  if (auto done = link(program.name_); !done) return fail(done.error());
  return program;
}

Program::~Program() {
  if (name_ != 0) glDeleteProgram(name_);
}

Status check_framebuffer(std::string_view what) {
  const GLenum state = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  if (state == GL_FRAMEBUFFER_COMPLETE) return {};
  return fail(fmt::format("the graphics driver cannot draw into {} (framebuffer state {:#x}); update it, or set "
                          "MESHLOOP_GPU=software",
                          what, state),
              ErrorKind::hardware_missing);
}

void read_floats(const Framebuffer& framebuffer, GLenum attachment, int width, int height, float* pixels) {
  read_channel(framebuffer, attachment, width, height, {GL_RED, GL_RGBA, GL_FLOAT}, pixels);
}

void read_unsigned(const Framebuffer& framebuffer, GLenum attachment, int width, int height, GLuint* pixels) {
  read_channel(framebuffer, attachment, width, height, {GL_RED_INTEGER, GL_RGBA_INTEGER, GL_UNSIGNED_INT}, pixels);
}

void read_bytes(const Framebuffer& framebuffer, GLenum attachment, int width, int height, GLubyte* pixels) {
  bind_for_reading(framebuffer, attachment);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  if (offers(GL_RED_INTEGER, GL_UNSIGNED_BYTE)) {
    glReadPixels(0, 0, width, height, GL_RED_INTEGER, GL_UNSIGNED_BYTE, pixels);
    return;
  }
  std::vector<GLuint> wide(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  read_unsigned(framebuffer, attachment, width, height, wide.data());
  std::transform(wide.begin(), wide.end(), pixels, [](GLuint value) { return static_cast<GLubyte>(value); });
}

}  // namespace meshloop
