#include "device/track/rendered_view.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "device/track/local_contrast.h"

namespace meshloop {
namespace {

/// Inverse depths may bend by this share within the neighbourhood; on a plane they are linear in the pixel.
constexpr double kBend = 0.02;
/// And may rise by this share from one side of it to the other.
constexpr double kSlope = 0.08;
constexpr int kRadius = 2;
constexpr int kRounds = 3;
constexpr double kClose_px = 0.1;

double inverse_depth_between(const DepthImage& depth, const Eigen::Vector2d& pixel) {
  const int x = static_cast<int>(std::floor(pixel.x()));
  const int y = static_cast<int>(std::floor(pixel.y()));
  const double right = pixel.x() - x;
  const double down = pixel.y() - y;
  const auto inverse = [&](int dx, int dy) { return 1.0 / static_cast<double>(depth(x + dx, y + dy)); };
  return (1 - down) * ((1 - right) * inverse(0, 0) + right * inverse(1, 0)) +
         down * ((1 - right) * inverse(0, 1) + right * inverse(1, 1));
}

/// All depths around the pixel are there, and the middle is the mean of each pair of opposite neighbours.
bool is_steady(const DepthImage& depth, int x, int y) {
  const auto at = [&](int dx, int dy) { return static_cast<double>(depth(x + dx, y + dy)); };
  const double middle = at(0, 0);
  if (middle <= 0) return false;
  for (int dy = 0; dy <= kRadius; ++dy) {
    for (int dx = -kRadius; dx <= kRadius; ++dx) {
      const double a = at(dx, dy);
      const double b = at(-dx, -dy);
      if (a <= 0 || b <= 0) return false;
      if (std::abs(0.5 * middle / a + 0.5 * middle / b - 1) > kBend) return false;
      if (std::abs(a - b) > 2 * kSlope * middle) return false;
    }
  }
  return true;
}

}  // namespace

RenderedView render_view(SceneRenderer& renderer, const Model& model, const Camera& camera,
                         const Pose& T_camera_world) {
  SceneView scene_view;
  scene_view.camera = camera;
  scene_view.T_camera_world = T_camera_world;
  renderer.render(model, scene_view);
  RenderedView view;
  view.camera = camera;
  view.T_camera_world = T_camera_world;
  view.depth = renderer.read_depth();
  view.grey = to_grey(renderer.read_color(&view.colored));
  const auto colored = std::count(view.colored.pixels().begin(), view.colored.pixels().end(), std::uint8_t{255});
  view.colored_share = static_cast<double>(colored) / static_cast<double>(std::max<std::size_t>(1, view.grey.size()));
  if (colored > 0) view.contrast = local_contrast(view.grey, view.colored, {});
  return view;
}

std::optional<double> steady_depth(const DepthImage& depth, const Eigen::Vector2d& pixel) {
  const double border = kRadius + 1;
  // Written so that a pixel that is not a number is refused.
  const bool inside = pixel.x() >= border && pixel.y() >= border && pixel.x() < depth.width() - 1 - border &&
                      pixel.y() < depth.height() - 1 - border;
  if (!inside) return std::nullopt;
  if (!is_steady(depth, static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y())))) {
    return std::nullopt;
  }
  return 1 / inverse_depth_between(depth, pixel);
}

std::optional<Eigen::Vector3d> world_point(const RenderedView& view, const Eigen::Vector2d& pixel) {
  const auto depth = steady_depth(view.depth, pixel);
  if (!depth) return std::nullopt;
  return view.T_camera_world.inverse() * view.camera.back_project(pixel.x(), pixel.y(), *depth);
}

std::optional<Eigen::Vector2d> pixel_in_view(const RenderedView& view, const Pose& T_other_world,
                                             const Eigen::Vector2d& pixel) {
  Eigen::Vector2d guess = pixel;
  for (int round = 0; round < kRounds; ++round) {
    const auto point = world_point(view, guess);
    if (!point) return std::nullopt;
    const Eigen::Vector3d p_other = T_other_world * *point;
    if (p_other.z() <= 0) return std::nullopt;
    const Eigen::Vector2d off = pixel - view.camera.project(p_other);
    if (off.norm() < kClose_px / 10) return guess;
    guess += off;
  }
  const auto point = world_point(view, guess);
  if (!point) return std::nullopt;
  const Eigen::Vector3d p_other = T_other_world * *point;
  if (p_other.z() <= 0 || (pixel - view.camera.project(p_other)).norm() > kClose_px) return std::nullopt;
  return guess;
}

GreyImage corner_mask(const RenderedView& view, int margin_px) {
  GreyImage mask{view.colored.width(), view.colored.height()};
  const cv::Mat colored{mask.height(), mask.width(), CV_8UC1, const_cast<std::uint8_t*>(view.colored.data())};
  cv::Mat eroded{mask.height(), mask.width(), CV_8UC1, mask.data()};
  const int side = 2 * margin_px + 1;
  cv::erode(colored, eroded, cv::getStructuringElement(cv::MORPH_RECT, {side, side}), {-1, -1}, 1, cv::BORDER_CONSTANT,
            cv::Scalar{0});
  return mask;
}

}  // namespace meshloop
