#include "common/gpu/image_upload.h"

#include <EGL/egl.h>
#include <GLES2/gl2ext.h>

#include <cstring>
#include <string_view>

namespace meshloop {
namespace {

constexpr GLbitfield kAccess = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT_EXT | GL_MAP_COHERENT_BIT_EXT;

PFNGLBUFFERSTORAGEEXTPROC buffer_storage() {
  return reinterpret_cast<PFNGLBUFFERSTORAGEEXTPROC>(eglGetProcAddress("glBufferStorageEXT"));
}

bool offers_buffer_storage() {
  GLint count = 0;
  glGetIntegerv(GL_NUM_EXTENSIONS, &count);
  for (GLint i = 0; i < count; ++i) {
    const auto* name = reinterpret_cast<const char*>(glGetStringi(GL_EXTENSIONS, static_cast<GLuint>(i)));
    if (name != nullptr && std::string_view{name} == "GL_EXT_buffer_storage") return buffer_storage() != nullptr;
  }
  return false;
}

/// Mesa's, which draw on the processor.
bool is_software() {
  const auto* name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  const std::string_view renderer{name != nullptr ? name : ""};
  return renderer.starts_with("llvmpipe") || renderer.starts_with("softpipe");
}

void copy_to(const Texture& texture, const Image<float>& image, const void* from) {
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, texture.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, image.width(), image.height(), GL_RED, GL_FLOAT, from);
}

}  // namespace

ImageUpload::ImageUpload(UploadPath path)
    : uses_buffers_{path != UploadPath::direct && (path == UploadPath::buffers || !is_software()) &&
                    offers_buffer_storage()} {}

ImageUpload::~ImageUpload() {
  // A buffer that goes is no longer mapped.
  for (const auto& slot : slots_) glDeleteSync(slot.is_free);
}

bool ImageUpload::make_room(std::size_t bytes) {
  if (bytes == bytes_) return true;
  bytes_ = 0;
  for (auto& slot : slots_) {
    wait_for(slot);
    slot.buffer = Buffer{};
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, slot.buffer.name());
    buffer_storage()(GL_PIXEL_UNPACK_BUFFER, static_cast<GLsizeiptr>(bytes), nullptr, kAccess);
    slot.mapped = glMapBufferRange(GL_PIXEL_UNPACK_BUFFER, 0, static_cast<GLsizeiptr>(bytes), kAccess);
    if (slot.mapped == nullptr) return false;
  }
  bytes_ = bytes;
  return true;
}

void ImageUpload::wait_for(Slot& slot) const {
  constexpr GLuint64 kSecond_ns = 1'000'000'000;
  if (slot.is_free == nullptr) return;
  glClientWaitSync(slot.is_free, GL_SYNC_FLUSH_COMMANDS_BIT, kSecond_ns);
  glDeleteSync(slot.is_free);
  slot.is_free = nullptr;
}

void ImageUpload::fill(const Texture& texture, const Image<float>& image) {
  const std::size_t bytes = image.size() * sizeof(float);
  if (!uses_buffers_ || !make_room(bytes)) {
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    copy_to(texture, image, image.data());
    return;
  }
  Slot& slot = slots_[next_];
  next_ = 1 - next_;
  wait_for(slot);
  std::memcpy(slot.mapped, image.data(), bytes);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, slot.buffer.name());
  copy_to(texture, image, nullptr);
  slot.is_free = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
}

}  // namespace meshloop
