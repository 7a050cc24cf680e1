#pragma once
#include <memory>
#include <string>

#include "common/base/result.h"

namespace meshloop {

class MeshCache;

/// A GLES 3.1 (or newer) context without a window. Made and used on one thread: every GL object of the project belongs
/// to the thread of its context. A thread may have several contexts, of which one is current: the last made, or the
/// last that was asked to be. Contexts share no objects.
class GpuContext {
 public:
  /// Tries, in this order: EGL devices that are hardware, Mesa's surfaceless platform, EGL devices in software. A
  /// failure names each attempt and what to install. The environment variable MESHLOOP_GPU=software leaves hardware
  /// out.
  [[nodiscard]] static Result<std::unique_ptr<GpuContext>> create_headless();

  ~GpuContext();
  GpuContext(const GpuContext&) = delete;
  GpuContext& operator=(const GpuContext&) = delete;

  /// Makes this the context that GL calls of this thread go to. Cheap when it is already.
  void make_current() const;

  /// The submeshes on the GPU, for all that draws in this context. Current first.
  [[nodiscard]] MeshCache& meshes() const { return *meshes_; }

  /// Renderer, version and platform: "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL ES 3.2, surfaceless".
  [[nodiscard]] const std::string& description() const { return description_; }

 private:
  struct Handles;
  GpuContext(std::unique_ptr<Handles> handles, std::string description);
  std::unique_ptr<Handles> handles_;
  std::unique_ptr<MeshCache> meshes_;
  std::string description_;
};

}  // namespace meshloop
