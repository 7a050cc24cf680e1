#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "server/adjust/proposal.h"

namespace meshloop::adjust {

struct ColorsOfPoints {
  std::vector<Rgb8> colors;
  /// 1 where there is a colour.
  std::vector<std::uint8_t> seen;
};

/// What the colour camera sees of points in the depth camera's frame (common/geometry/README.md, equation 4), with
/// visibility between the two cameras resolved: all measured surfaces are drawn into a depth buffer of the colour
/// camera first.
class ColorLookup {
 public:
  /// The snapshot's frame must outlive this.
  explicit ColorLookup(const Snapshot& snapshot);

  /// Bilinear, in coarse steps; nothing where the point lies outside the colour image, or behind another measured
  /// surface by more than three sigma and what two neighbouring pixels of one surface can differ.
  [[nodiscard]] std::optional<Rgb8> color_of(const Eigen::Vector3f& p_depth, float sigma_m) const;

  /// The same for a picture of what is seen: cubic and not rounded, since who draws a texture interpolates once more.
  [[nodiscard]] std::optional<Rgb8> texel_of(const Eigen::Vector3f& p_depth, float sigma_m) const;

  /// As color_of for many; as many sigmas as points.
  [[nodiscard]] ColorsOfPoints colors_of(std::span<const Eigen::Vector3f> points_depth,
                                         std::span<const float> sigmas_m) const;

 private:
  /// In cells of the buffer, and metres along the colour camera's axis; of one row of the depth image.
  struct Places {
    float* u;
    float* v;
    float* z;
  };
  void project_row(const DepthImage& measured, int y, const Camera& depth, const Places& places) const;
  void draw(const DepthImage& measured, const Camera& depth);
  /// What a look at one point needs, in single precision. Copied to where many points are looked up: a copy cannot be
  /// what the colours are written to, so that it need not be read again for each point.
  struct View {
    Eigen::Matrix3f R_color_depth;
    Eigen::Vector3f t_color_depth;
    Eigen::Vector2f focal_px;
    Eigen::Vector2f centre_px;
    /// Cells of the depth buffer per pixel, and their number.
    float scale = 1;
    int columns = 0;
    int rows = 0;
    float step_per_m = 0;
    const float* nearest = nullptr;
    const Rgb8* color = nullptr;
    int width = 0;
    int height = 0;

    /// The pixel of the colour image that shows a point, which nothing hides.
    [[nodiscard]] std::optional<Eigen::Vector2f> seen_at(const Eigen::Vector3f& p_depth, float sigma_m) const;
    [[nodiscard]] Rgb8 bilinear(float u, float v) const;
  };
  [[nodiscard]] View view() const;

  const ColorImage* color_;
  Camera camera_;
  Eigen::Matrix3f R_color_depth_;
  Eigen::Vector3f t_color_depth_;
  /// Cells of the buffer per pixel of the colour image: a cell is about as wide as a depth pixel.
  float scale_ = 1;
  float step_per_m_ = 0;
  DepthImage nearest_;
};

}  // namespace meshloop::adjust
