#include "server/compare/comparator.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "common/base/clock.h"
#include "common/gpu/gl_objects.h"
#include "common/gpu/image_upload.h"
#include "common/gpu/mesh_cache.h"
#include "common/gpu/scene_renderer.h"
#include "server/compare/compare_input.h"
#include "server/compare/compare_parameters.h"
#include "shaders/shaders.h"

namespace meshloop {
namespace {

struct Targets {
  int width;
  int height;
  Texture measured;
  Texture frames_averaged;
  Texture threshold;
  Texture label;
  /// Which pixels the second pass goes on with.
  Texture progress;
  Framebuffer framebuffer;

  Targets(int wide, int high)
      : width{wide},
        height{high},
        measured{make_texture(GL_R32F, wide, high)},
        frames_averaged{make_texture(GL_R32F, wide, high)},
        threshold{make_texture(GL_R32F, wide, high)},
        label{make_texture(GL_R8UI, wide, high)},
        progress{make_texture(GL_DEPTH_COMPONENT16, wide, high)} {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, threshold.name(), 0);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT1, GL_TEXTURE_2D, label.name(), 0);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, progress.name(), 0);
    draw_into(GL_COLOR_ATTACHMENT0);
  }

  /// Labels always; thresholds into `threshold_attachment`, or GL_NONE.
  static void draw_into(GLenum threshold_attachment) {
    const std::array<GLenum, 2> wanted{threshold_attachment, GL_COLOR_ATTACHMENT1};
    glDrawBuffers(static_cast<GLsizei>(wanted.size()), wanted.data());
  }
};

Tolerance tolerance_of(const CompareInput& input) {
  if (input.detail_share <= 0 || input.frames_averaged != nullptr) return {};
  const bool is_fixed = input.threshold.kind == Threshold::Kind::fixed;
  // A threshold in metres stands for three sigma.
  const double most_m = is_fixed ? input.threshold.value / 3 : std::numeric_limits<double>::infinity();
  return Tolerance{[&](double z_m) { return input.detail_share * std::min(most_m, input.sensor.sigma_z_m(z_m, 0)); }};
}

bool offers(GLenum limit, GLint needed) {
  GLint offered = 0;
  glGetIntegerv(limit, &offered);
  return offered >= needed;
}

// OpenGL ES 3.1 promises no images in fragment shaders, and four together with the outputs.
Status check_images() {
  if (offers(GL_MAX_FRAGMENT_IMAGE_UNIFORMS, 3) && offers(GL_MAX_COMBINED_SHADER_OUTPUT_RESOURCES, 5)) return {};
  return fail("the graphics driver offers too few images in fragment shaders; update it, or set MESHLOOP_GPU=software",
              ErrorKind::hardware_missing);
}

void bind_image(GLuint unit, GLuint texture) {
  glBindImageTexture(unit, texture, 0, GL_FALSE, 0, GL_READ_ONLY, GL_R32F);
}

Image<float> difference_of(const DepthImage& measured, const DepthImage& expected) {
  Image<float> difference(measured.width(), measured.height());
  for (std::size_t i = 0; i < difference.size(); ++i) {
    const float measured_m = measured.data()[i];
    const float expected_m = expected.data()[i];
    const bool both = measured_m > 0 && expected_m > 0;
    difference.data()[i] = both ? measured_m - expected_m : std::numeric_limits<float>::quiet_NaN();
  }
  return difference;
}

/// The two passes.
struct Passes {
  Program every_pixel;
  Program around;
};

struct Programs {
  /// For exact intrinsics and a single measured frame.
  Passes plain;
  Passes every_term;
  [[nodiscard]] const Passes& for_input(const CompareInput& input) const {
    const bool is_plain = input.frames_averaged == nullptr && input.intrinsics_covariance.isZero(0);
    return is_plain ? plain : every_term;
  }
};

/// `define` becomes the line after the first one, which must be `#version`.
Result<Passes> create_passes(std::string_view define) {
  const auto defined = [&](std::string_view source) {
    const std::size_t second_line = source.find('\n') + 1;
    return fmt::format("{}{}\n{}", source.substr(0, second_line), define, source.substr(second_line));
  };
  auto every_pixel = Program::create(shaders::compare_vert, defined(shaders::compare_frag));
  if (!every_pixel) return fail("preparing the comparison", every_pixel.error());
  auto around = Program::create(shaders::compare_vert, defined(shaders::compare_around_frag));
  if (!around) return fail("preparing the comparison", around.error());
  return Passes{std::move(*every_pixel), std::move(*around)};
}

class GlComparator final : public Comparator {
 public:
  GlComparator(GpuContext& context, std::unique_ptr<SceneRenderer> renderer, Programs programs, Targets targets)
      : context_{context},
        renderer_{std::move(renderer)},
        programs_{std::move(programs)},
        targets_{std::move(targets)} {}
  GlComparator(const GlComparator&) = delete;
  GlComparator& operator=(const GlComparator&) = delete;
  // The members are freed in the context that made them.
  ~GlComparator() override { context_.make_current(); }

  Result<Comparison> compare(const CompareInput& input, CompareTimes* times) override;

 private:
  void upload(const DepthImage& measured, const Image<std::uint8_t>* frames_averaged);
  void draw(const CompareInput& input);
  void draw_pass(const Program& program, const Parameters& parameters) const;
  [[nodiscard]] Comparison read_back();

  GpuContext& context_;
  std::unique_ptr<SceneRenderer> renderer_;
  Programs programs_;
  Targets targets_;
  ImageUpload upload_{UploadPath::by_driver};
  VertexArray no_vertices_;
  /// Kept from frame to frame: memory that is new to the process costs more than the copy into it.
  DepthImage measured_;
};

void GlComparator::upload(const DepthImage& measured, const Image<std::uint8_t>* frames_averaged) {
  if (measured.width() != targets_.width || measured.height() != targets_.height) {
    targets_ = Targets(measured.width(), measured.height());
  }
  upload_.fill(targets_.measured, measured);
  if (frames_averaged == nullptr) return;
  Image<float> frames(frames_averaged->width(), frames_averaged->height());
  std::copy_n(frames_averaged->data(), frames.size(), frames.data());
  upload_.fill(targets_.frames_averaged, frames);
}

// The renderer, which has just drawn, left blending, culling and scissors off and the depth test on. Both passes cover
// the picture at the same depth; only the first one writes another.
void GlComparator::draw(const CompareInput& input) {
  glBindFramebuffer(GL_FRAMEBUFFER, targets_.framebuffer.name());
  glViewport(0, 0, targets_.width, targets_.height);
  bind_image(0, targets_.measured.name());
  bind_image(1, renderer_->depth_texture());
  // Some programs read it in any case, and use it only for a mean of frames; what is in the cache already costs less.
  bind_image(2, (input.frames_averaged != nullptr ? targets_.frames_averaged : targets_.measured).name());
  glBindVertexArray(no_vertices_.name());
  const Passes& passes = programs_.for_input(input);
  const Parameters parameters = parameters_of(input);
  Targets::draw_into(GL_COLOR_ATTACHMENT0);
  glDepthFunc(GL_ALWAYS);
  draw_pass(passes.every_pixel, parameters);
  Targets::draw_into(GL_NONE);
  glDepthFunc(GL_GREATER);
  if (input.threshold.kind == Threshold::Kind::k_sigma) draw_pass(passes.around, parameters);
  glBindVertexArray(0);
}

void GlComparator::draw_pass(const Program& program, const Parameters& parameters) const {
  constexpr GLint kParameters = 0;
  program.use();
  glUniform4fv(kParameters, sizeof parameters / sizeof(Parameters::Vec4), reinterpret_cast<const float*>(&parameters));
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

Comparison GlComparator::read_back() {
  Comparison result;
  result.labels = Image<Label>(targets_.width, targets_.height);
  result.threshold_m = Image<float>(targets_.width, targets_.height);
  read_floats(targets_.framebuffer, GL_COLOR_ATTACHMENT0, targets_.width, targets_.height, result.threshold_m.data());
  static_assert(sizeof(Label) == sizeof(GLubyte));
  read_bytes(targets_.framebuffer, GL_COLOR_ATTACHMENT1, targets_.width, targets_.height,
             reinterpret_cast<GLubyte*>(result.labels.data()));
  result.expected = renderer_->read_depth();
  result.node_index = renderer_->read_nodes();
  result.difference_m = difference_of(measured_, result.expected);
  return result;
}

Result<Comparison> GlComparator::compare(const CompareInput& input, CompareTimes* times) {
  if (auto valid = validate(input); !valid) return fail(valid.error());
  context_.make_current();
  Stopwatch watch;
  // Waiting between the steps costs a little; it is done only where times are asked for.
  const auto lap = [&](double CompareTimes::*step) {
    if (times == nullptr) return;
    glFinish();
    times->*step = watch.milliseconds();
    watch.restart();
  };
  measured_ = *input.measured;
  for (float& z : measured_.pixels()) z = usable_depth(z);
  upload(measured_, input.frames_averaged);
  lap(&CompareTimes::upload_ms);
  SceneView view;
  view.camera = input.camera;
  view.T_camera_world = input.pose.T_camera_world;
  view.tolerance = tolerance_of(input);
  view.color = false;
  if (input.wait_for_detail && !view.tolerance.is_exact()) context_.meshes().finish(*input.model);
  renderer_->render(*input.model, view);
  lap(&CompareTimes::render_ms);
  draw(input);
  lap(&CompareTimes::compare_ms);
  Comparison result = read_back();
  // Without this an image that the driver had no room for would read as "nothing was measured".
  if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
    return fail(fmt::format("the graphics driver could not compare {} x {} pixels (OpenGL error {:#x})",
                            measured_.width(), measured_.height(), error));
  }
  lap(&CompareTimes::readback_ms);
  return result;
}

}  // namespace

Result<std::unique_ptr<Comparator>> Comparator::create(GpuContext& context) {
  constexpr int kFirstSize = 16;
  auto renderer = SceneRenderer::create(context);
  if (!renderer) return fail(renderer.error());
  if (auto usable = check_images(); !usable) return fail(usable.error());
  auto plain = create_passes("");
  if (!plain) return fail(plain.error());
  auto every_term = create_passes("#define EVERY_TERM");
  if (!every_term) return fail(every_term.error());
  Targets targets(kFirstSize, kFirstSize);
  if (auto usable = check_framebuffer("images of labels and thresholds"); !usable) return fail(usable.error());
  return std::unique_ptr<Comparator>{std::make_unique<GlComparator>(
      context, std::move(*renderer), Programs{std::move(*plain), std::move(*every_term)}, std::move(targets))};
}

}  // namespace meshloop
