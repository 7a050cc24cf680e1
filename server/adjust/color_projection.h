#pragma once
// Where the colour camera sees points in the depth camera's frame: many at once, without branches.
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

namespace meshloop::adjust {

/// The colour camera, and the depth buffer of what it sees.
struct ColorView {
  Eigen::Matrix3f R_color_depth = Eigen::Matrix3f::Identity();
  Eigen::Vector3f t_color_depth = Eigen::Vector3f::Zero();
  float fx = 1;
  float fy = 1;
  float cx = 0;
  float cy = 0;
  int width = 0;
  int height = 0;
  /// Cells of the depth buffer per pixel, and how many there are.
  float scale = 1;
  int columns = 0;
  int rows = 0;
};

/// So many points that what is known of them stays in the fastest memory.
inline constexpr std::size_t kPointsAtOnce = 256;

template <class T>
using OfPoints = std::array<T, kPointsAtOnce>;

struct ProjectedPoints {
  /// Pixels of the colour image; 0 for what is not inside.
  OfPoints<float> u;
  OfPoints<float> v;
  /// Metres along the colour camera's axis.
  OfPoints<float> z;
  /// Of the depth buffer.
  OfPoints<std::int32_t> cell;
  /// 1 in front of the camera and not beside its image, else 0.
  OfPoints<std::int32_t> inside;
};

/// `count` points, at most kPointsAtOnce. The view must have a depth buffer.
void project_points(const ColorView& view, const Eigen::Vector3f* points_depth, std::size_t count,
                    ProjectedPoints& projected);

/// `count` pixels of a row of the depth image: along the ray `first + x * along`, up to the depth z[x]. In cells of the
/// view's depth buffer; z_color is -1 for what was not measured.
struct ProjectedRow {
  float* u;
  float* v;
  float* z_color;
};
void project_row(const ColorView& view, const Eigen::Vector3f& first, const Eigen::Vector3f& along, const float* z,
                 std::size_t count, const ProjectedRow& projected);

/// The four pixels around a place: the number of the top left one in the image, and how far on it is to the next ones.
struct PixelCorners {
  OfPoints<std::int32_t> top_left;
  OfPoints<std::int32_t> right_units;
  OfPoints<std::int32_t> down_units;
};
inline constexpr int kUnitsPerPixel = 32;

/// Places beyond the outermost pixels' centres are moved there; the image must have two pixels each way.
void find_corners(const ColorView& view, const ProjectedPoints& projected, std::size_t count, PixelCorners& corners);

}  // namespace meshloop::adjust
