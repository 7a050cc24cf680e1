#pragma once
#include <GLES3/gl31.h>

#include <array>
#include <cstddef>

#include "common/gpu/gl_objects.h"
#include "common/image/image.h"

namespace meshloop {

/// How images get to the GPU. Through buffers: two of them stay mapped (GL_EXT_buffer_storage) and take turns, so that
/// the driver copies one while the next frame is written. Directly: it copies before the call returns, which on a
/// software renderer is one copy less.
enum class UploadPath { by_driver, direct, buffers };

/// Fills textures of one float a pixel. Belongs to the thread and context that made it.
class ImageUpload {
 public:
  /// By the driver: through buffers on hardware that offers them. Where it does not, `buffers` is direct as well.
  explicit ImageUpload(UploadPath path);
  ImageUpload(const ImageUpload&) = delete;
  ImageUpload& operator=(const ImageUpload&) = delete;
  ~ImageUpload();

  [[nodiscard]] bool uses_buffers() const { return uses_buffers_; }
  /// The texture has the image's size.
  void fill(const Texture& texture, const Image<float>& image);

 private:
  struct Slot {
    Buffer buffer;
    void* mapped = nullptr;
    /// Signalled when the driver has read what was written last.
    GLsync is_free = nullptr;
  };
  [[nodiscard]] bool make_room(std::size_t bytes);
  void wait_for(Slot& slot) const;

  bool uses_buffers_ = false;
  std::size_t bytes_ = 0;
  std::array<Slot, 2> slots_;
  std::size_t next_ = 0;
};

}  // namespace meshloop
