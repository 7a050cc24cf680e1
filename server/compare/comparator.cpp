#include "server/compare/comparator.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "common/base/clock.h"
#include "common/change/classify_rule.h"
#include "common/gpu/gl_objects.h"
#include "common/gpu/mesh_cache.h"
#include "common/gpu/scene_renderer.h"
#include "server/compare/compare_input.h"
#include "shaders/shaders.h"

namespace meshloop {
namespace {

// Locations of the uniforms in shaders/compare.glsl.
enum Uniform : GLint {
  kIntrinsics,
  kSensorAxial,
  kSensorShape,
  kLateral,
  kFixedThreshold,
  kSigmas,
  kModelVariance,
  kLargestThreshold,
  kLargestReach,
  kCovarianceTt,
  kCovarianceTr,
  kCovarianceRr,
  kCovarianceIntrinsics,
  kIsAveraged
};

// What the shader writes for one pixel.
struct PackedPixel {
  std::uint32_t threshold_bits;
  std::uint32_t label;
};
static_assert(sizeof(PackedPixel) == 8);

struct Targets {
  int width;
  int height;
  Texture measured;
  Texture frames_averaged;
  Texture result;
  /// Which pixels the second pass goes on with.
  Texture progress;
  Framebuffer framebuffer;

  Targets(int wide, int high)
      : width{wide},
        height{high},
        measured{make_texture(GL_R32F, wide, high)},
        frames_averaged{make_texture(GL_R8UI, wide, high)},
        result{make_texture(GL_RG32UI, wide, high)},
        progress{make_texture(GL_DEPTH_COMPONENT16, wide, high)} {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, result.name(), 0);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, progress.name(), 0);
  }
};

/// On no surface that was looked at was the root mean square of a simplified one's deviation more than a fifth of the
/// largest (README.md, "Levels of detail").
constexpr double kLargestByRms = 5;

Tolerance tolerance_of(const CompareInput& input) {
  if (input.detail_share <= 0 || input.frames_averaged != nullptr) return {};
  const bool is_fixed = input.threshold.kind == Threshold::Kind::fixed;
  // A threshold in metres stands for three sigma.
  const double most_m = is_fixed ? input.threshold.value / 3 : std::numeric_limits<double>::infinity();
  return Tolerance{[&](double z_m) {
    return kLargestByRms * input.detail_share * std::min(most_m, input.sensor.sigma_z_m(z_m, 0));
  }};
}

void set_matrix(Uniform location, const Eigen::Matrix3d& matrix) {
  const Eigen::Matrix3f values = matrix.cast<float>();
  glUniformMatrix3fv(location, 1, GL_FALSE, values.data());
}

void set_sensor(const SensorNoise& noise) {
  const Eigen::Vector3f axial = noise.axial.cast<float>();
  glUniform3f(kSensorAxial, axial[0], axial[1], axial[2]);
  glUniform4f(kSensorShape, static_cast<float>(noise.nearest_m), static_cast<float>(noise.farthest_m),
              noise.grows_at_grazing ? 1.0F : 0.0F, static_cast<float>(noise.step_per_m));
  glUniform3f(kLateral, static_cast<float>(noise.lateral_px), static_cast<float>(noise.lateral_growth_px),
              static_cast<float>(kFootprintSigma_px));
}

void set_uniforms(const CompareInput& input) {
  const Camera& camera = input.camera;
  const bool is_fixed = input.threshold.kind == Threshold::Kind::fixed;
  const auto value = static_cast<float>(input.threshold.value);
  glUniform4f(kIntrinsics, static_cast<float>(camera.fx), static_cast<float>(camera.fy), static_cast<float>(camera.cx),
              static_cast<float>(camera.cy));
  set_sensor(input.sensor.noise());
  glUniform1f(kFixedThreshold, is_fixed ? value : 0.0F);
  glUniform1f(kSigmas, value);
  glUniform1f(kModelVariance,
              static_cast<float>(input.model_sigma_m * input.model_sigma_m + kLatticeSigma_m * kLatticeSigma_m));
  glUniform1f(kLargestThreshold, static_cast<float>(kLargestThreshold_m));
  glUniform1i(kLargestReach, kLargestReach_px);
  const PoseCovariance covariance = 0.5 * (input.pose.covariance + input.pose.covariance.transpose());
  set_matrix(kCovarianceTt, covariance.topLeftCorner<3, 3>());
  set_matrix(kCovarianceTr, covariance.topRightCorner<3, 3>());
  set_matrix(kCovarianceRr, covariance.bottomRightCorner<3, 3>());
  const Eigen::Matrix4f intrinsics = input.intrinsics_covariance.cast<float>();
  glUniformMatrix4fv(kCovarianceIntrinsics, 1, GL_FALSE, intrinsics.data());
  glUniform1i(kIsAveraged, input.frames_averaged != nullptr ? 1 : 0);
}

void bind_texture(GLuint unit, GLuint texture) {
  glActiveTexture(GL_TEXTURE0 + unit);
  glBindTexture(GL_TEXTURE_2D, texture);
}

Comparison unpack(const Image<PackedPixel>& packed, const DepthImage& measured, DepthImage expected,
                  Image<std::uint32_t> nodes) {
  const int width = packed.width();
  const int height = packed.height();
  Comparison result{Image<Label>(width, height), Image<float>(width, height), std::move(expected), std::move(nodes),
                    Image<float>(width, height)};
  for (std::size_t i = 0; i < packed.size(); ++i) {
    const PackedPixel& pixel = packed.data()[i];
    const float expected_m = result.expected.data()[i];
    const float threshold_m = std::bit_cast<float>(pixel.threshold_bits);
    const float measured_m = measured.data()[i];
    const bool both = expected_m > 0 && measured_m > 0;
    result.labels.data()[i] = static_cast<Label>(pixel.label);
    result.threshold_m.data()[i] =
        threshold_m < rule::kNoThreshold_m ? threshold_m : std::numeric_limits<float>::infinity();
    result.difference_m.data()[i] = both ? measured_m - expected_m : std::numeric_limits<float>::quiet_NaN();
  }
  return result;
}

struct Programs {
  Program every_pixel;
  Program around;
};

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
  void draw_pass(const Program& program, const CompareInput& input) const;
  void read_back();

  GpuContext& context_;
  std::unique_ptr<SceneRenderer> renderer_;
  Programs programs_;
  Targets targets_;
  VertexArray no_vertices_;
  /// Kept from frame to frame: memory that is new to the process costs more than the copy into it.
  DepthImage measured_;
  Image<PackedPixel> packed_;
};

void GlComparator::upload(const DepthImage& measured, const Image<std::uint8_t>* frames_averaged) {
  if (measured.width() != targets_.width || measured.height() != targets_.height) {
    targets_ = Targets(measured.width(), measured.height());
  }
  bind_texture(0, targets_.measured.name());
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, measured.width(), measured.height(), GL_RED, GL_FLOAT, measured.data());
  if (frames_averaged == nullptr) return;
  bind_texture(2, targets_.frames_averaged.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, measured.width(), measured.height(), GL_RED_INTEGER, GL_UNSIGNED_BYTE,
                  frames_averaged->data());
}

// The renderer, which has just drawn, left blending, culling and scissors off and the depth test on. Both passes cover
// the picture at the same depth; only the first one writes another.
void GlComparator::draw(const CompareInput& input) {
  glBindFramebuffer(GL_FRAMEBUFFER, targets_.framebuffer.name());
  glViewport(0, 0, targets_.width, targets_.height);
  bind_texture(2, targets_.frames_averaged.name());
  bind_texture(1, renderer_->depth_texture());
  bind_texture(0, targets_.measured.name());
  glBindVertexArray(no_vertices_.name());
  glDepthFunc(GL_ALWAYS);
  draw_pass(programs_.every_pixel, input);
  glDepthFunc(GL_GREATER);
  if (input.threshold.kind == Threshold::Kind::k_sigma) draw_pass(programs_.around, input);
  glBindVertexArray(0);
}

void GlComparator::draw_pass(const Program& program, const CompareInput& input) const {
  program.use();
  set_uniforms(input);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void GlComparator::read_back() {
  if (packed_.width() != targets_.width || packed_.height() != targets_.height) {
    packed_ = Image<PackedPixel>(targets_.width, targets_.height);
  }
  read_unsigned_pairs(targets_.framebuffer, GL_COLOR_ATTACHMENT0, targets_.width, targets_.height,
                      &packed_.data()->threshold_bits);
}

Result<Comparison> GlComparator::compare(const CompareInput& input, CompareTimes* times) {
  if (auto valid = validate(input); !valid) return fail(valid.error());
  context_.make_current();
  Stopwatch watch;
  // Waiting between the steps costs time; it is done only for somebody who wants to know.
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
  read_back();
  DepthImage expected = renderer_->read_depth();
  Image<std::uint32_t> nodes = renderer_->read_nodes();
  // Without this an image that the driver had no room for would read as "nothing was measured".
  if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
    return fail(fmt::format("the graphics driver could not compare {} x {} pixels (OpenGL error {:#x})",
                            measured_.width(), measured_.height(), error));
  }
  auto result = unpack(packed_, measured_, std::move(expected), std::move(nodes));
  lap(&CompareTimes::readback_ms);
  return result;
}

}  // namespace

Result<std::unique_ptr<Comparator>> Comparator::create(GpuContext& context) {
  constexpr int kFirstSize = 16;
  auto renderer = SceneRenderer::create(context);
  if (!renderer) return fail(renderer.error());
  auto every_pixel = Program::create(shaders::compare_vert, shaders::compare_frag);
  if (!every_pixel) return fail("preparing the comparison", every_pixel.error());
  auto around = Program::create(shaders::compare_vert, shaders::compare_around_frag);
  if (!around) return fail("preparing the comparison", around.error());
  Targets targets(kFirstSize, kFirstSize);
  if (auto usable = check_framebuffer("images of labels and thresholds"); !usable) return fail(usable.error());
  return std::unique_ptr<Comparator>{std::make_unique<GlComparator>(
      context, std::move(*renderer), Programs{std::move(*every_pixel), std::move(*around)}, std::move(targets))};
}

}  // namespace meshloop
