#include "common/gpu/context.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GLES3/gl31.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "common/gpu/mesh_cache.h"

namespace meshloop {

struct GpuContext::Handles {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;

  Handles(EGLDisplay of, EGLContext made) : display{of}, context{made} {}
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;
  // The display stays initialised: it is one for the whole process, and ending it would end every other context on it.
  ~Handles() {
    if (eglGetCurrentContext() == context) eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display, context);
  }
};

namespace {

enum class Accepts { any_renderer, software_renderer };

struct Attempt {
  std::string platform;
  EGLenum egl_platform;
  void* native_display;
  Accepts accepts = Accepts::any_renderer;
};

bool has_word(const char* words, std::string_view word) {
  if (words == nullptr) return false;
  std::string_view rest{words};
  while (!rest.empty()) {
    const auto end = rest.find(' ');
    if (rest.substr(0, end) == word) return true;
    if (end == std::string_view::npos) break;
    rest.remove_prefix(end + 1);
  }
  return false;
}

std::vector<Attempt> device_attempts(bool software) {
  const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (!has_word(extensions, "EGL_EXT_platform_device")) return {};
  const auto query = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
  const auto text = reinterpret_cast<PFNEGLQUERYDEVICESTRINGEXTPROC>(eglGetProcAddress("eglQueryDeviceStringEXT"));
  if (query == nullptr || text == nullptr) return {};
  std::array<EGLDeviceEXT, 16> devices{};
  EGLint count = 0;
  if (query(static_cast<EGLint>(devices.size()), devices.data(), &count) == EGL_FALSE) return {};
  std::vector<Attempt> attempts;
  for (int i = 0; i < count; ++i) {
    void* const device = devices[static_cast<std::size_t>(i)];
    if (has_word(text(device, EGL_EXTENSIONS), "EGL_MESA_device_software") != software) continue;
    attempts.push_back(
        {fmt::format("{} device {}", software ? "software" : "hardware", i), EGL_PLATFORM_DEVICE_EXT, device});
  }
  return attempts;
}

Result<std::vector<Attempt>> all_attempts() {
  const char* wish = std::getenv("MESHLOOP_GPU");
  const std::string_view wanted = wish == nullptr ? "" : wish;
  if (!wanted.empty() && wanted != "software") {
    return fail(fmt::format("MESHLOOP_GPU={} is not known; set it to 'software' or leave it out", wanted),
                ErrorKind::usage);
  }
  std::vector<Attempt> attempts;
  Attempt surfaceless{"surfaceless", EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY};
  // Mesa's surfaceless platform takes a graphics card where there is one.
  if (wanted == "software") {
    surfaceless.accepts = Accepts::software_renderer;
  } else {
    attempts = device_attempts(false);
  }
  attempts.push_back(surfaceless);
  for (auto& attempt : device_attempts(true)) attempts.push_back(std::move(attempt));
  return attempts;
}

tl::unexpected<Error> egl_failure(std::string_view call) {
  return fail(fmt::format("{} failed with EGL error {:#x}", call, eglGetError()), ErrorKind::hardware_missing);
}

Result<EGLDisplay> open_display(const Attempt& attempt) {
  EGLDisplay display = eglGetPlatformDisplay(attempt.egl_platform, attempt.native_display, nullptr);
  if (display == EGL_NO_DISPLAY) return egl_failure("eglGetPlatformDisplay");
  if (eglInitialize(display, nullptr, nullptr) == EGL_FALSE) return egl_failure("eglInitialize");
  if (eglBindAPI(EGL_OPENGL_ES_API) == EGL_FALSE) return egl_failure("eglBindAPI");
  if (!has_word(eglQueryString(display, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context")) {
    return fail("the driver needs a window (no EGL_KHR_surfaceless_context)", ErrorKind::hardware_missing);
  }
  return display;
}

// EGL_NO_CONFIG_KHR where the driver can do without a configuration.
Result<EGLConfig> choose_config(EGLDisplay display) {
  if (has_word(eglQueryString(display, EGL_EXTENSIONS), "EGL_KHR_no_config_context")) return EGL_NO_CONFIG_KHR;
  const std::array<EGLint, 5> wanted{EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT, EGL_SURFACE_TYPE, EGL_DONT_CARE,
                                     EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (eglChooseConfig(display, wanted.data(), &config, 1, &count) == EGL_FALSE || count == 0) {
    return egl_failure("eglChooseConfig");
  }
  return config;
}

Result<EGLContext> make_context(EGLDisplay display) {
  const auto config = choose_config(display);
  if (!config) return fail(config.error());
  for (const EGLint minor : {2, 1}) {
    const std::array<EGLint, 5> version{EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, minor, EGL_NONE};
    EGLContext context = eglCreateContext(display, *config, EGL_NO_CONTEXT, version.data());
    if (context != EGL_NO_CONTEXT) return context;
  }
  return egl_failure("eglCreateContext for OpenGL ES 3.1");
}

std::string_view gl_text(GLenum what) {
  const GLubyte* text = glGetString(what);
  return text == nullptr ? "unknown" : reinterpret_cast<const char*>(text);
}

bool is_software(std::string_view renderer) {
  return renderer.find("llvmpipe") != renderer.npos || renderer.find("softpipe") != renderer.npos;
}

// Drawing to float targets is core from 3.2 on.
Status check_abilities() {
  GLint minor = 0;
  GLint count = 0;
  glGetIntegerv(GL_MINOR_VERSION, &minor);
  glGetIntegerv(GL_NUM_EXTENSIONS, &count);
  if (minor >= 2) return {};
  for (GLint i = 0; i < count; ++i) {
    const GLubyte* extension = glGetStringi(GL_EXTENSIONS, static_cast<GLuint>(i));
    if (std::string_view{reinterpret_cast<const char*>(extension)} == "GL_EXT_color_buffer_float") return {};
  }
  return fail("the driver cannot draw to float images (no GL_EXT_color_buffer_float)", ErrorKind::hardware_missing);
}

// "OpenGL ES 3.2 Mesa 22.3.6" without the driver's own words.
std::string_view version_text() {
  const std::string_view text = gl_text(GL_VERSION);
  constexpr std::size_t kLength = std::string_view{"OpenGL ES 3.2"}.size();
  return text.substr(0, kLength);
}

}  // namespace

Result<std::unique_ptr<GpuContext>> GpuContext::create_headless() {
  const auto attempts = all_attempts();
  if (!attempts) return fail(attempts.error());
  std::vector<std::string> failures;
  const auto try_one = [](const Attempt& attempt) -> Result<std::unique_ptr<GpuContext>> {
    const auto display = open_display(attempt);
    if (!display) return fail(display.error());
    const auto context = make_context(*display);
    if (!context) return fail(context.error());
    auto handles = std::make_unique<Handles>(*display, *context);
    if (eglMakeCurrent(*display, EGL_NO_SURFACE, EGL_NO_SURFACE, *context) == EGL_FALSE) {
      return egl_failure("eglMakeCurrent");
    }
    if (attempt.accepts == Accepts::software_renderer && !is_software(gl_text(GL_RENDERER))) {
      return fail("draws in hardware, which MESHLOOP_GPU=software excludes", ErrorKind::hardware_missing);
    }
    if (auto able = check_abilities(); !able) return fail(able.error());
    auto description = fmt::format("{}, {}, {}", gl_text(GL_RENDERER), version_text(), attempt.platform);
    return std::unique_ptr<GpuContext>{new GpuContext(std::move(handles), std::move(description))};
  };
  for (const auto& attempt : *attempts) {
    auto context = try_one(attempt);
    if (context) return context;
    failures.push_back(fmt::format("{}: {}", attempt.platform, context.error().message));
  }
  return fail(fmt::format("no OpenGL ES 3.1 context ({}); install the packages libegl1 and libgl1-mesa-dri, or the "
                          "driver of your graphics card",
                          fmt::join(failures, "; ")),
              ErrorKind::hardware_missing);
}

GpuContext::GpuContext(std::unique_ptr<Handles> handles, std::string description)
    : handles_{std::move(handles)}, meshes_{std::make_unique<MeshCache>()}, description_{std::move(description)} {}

GpuContext::~GpuContext() {
  make_current();
  meshes_.reset();
}

void GpuContext::make_current() const {
  if (eglGetCurrentContext() == handles_->context) return;
  eglMakeCurrent(handles_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, handles_->context);
}

}  // namespace meshloop
