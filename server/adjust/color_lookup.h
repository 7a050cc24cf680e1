#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "server/adjust/color_projection.h"
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
  void draw(const DepthImage& measured, const Camera& depth);
  /// For up to kPointsAtOnce points: 1 where the colour camera sees one, which nothing hides.
  void look(std::span<const Eigen::Vector3f> points_depth, std::span<const float> sigmas_m, ProjectedPoints& projected,
            std::uint8_t* seen) const;
  /// The pixel of the colour image that shows a point.
  [[nodiscard]] std::optional<Eigen::Vector2f> seen_at(const Eigen::Vector3f& p_depth, float sigma_m) const;

  const ColorImage* color_;
  ColorView view_;
  float step_per_m_ = 0;
  DepthImage nearest_;
};

}  // namespace meshloop::adjust
