#pragma once
// Square markers in an image, and the camera's pose from them. The only user of OpenCV's aruco module (its API changes
// at OpenCV 4.7).
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/features/robust_pose.h"
#include "common/image/image.h"
#include "common/recording/marker_file.h"

namespace meshloop {

/// Standard deviation of a refined corner; 0.04 px were measured on rendered views, see the README.
inline constexpr double kMarkerCornerSigmaPx = 0.1;
/// And of one that could not be refined, as in small pictures; 0.52 px were measured.
inline constexpr double kRoughCornerSigmaPx = 0.5;

struct MarkerSighting {
  int id = 0;
  /// Refined to sub-pixel accuracy, in the order of Marker::corners.
  std::array<Eigen::Vector2d, 4> pixels;
  /// Of each coordinate of a corner.
  double sigma_px = kMarkerCornerSigmaPx;
};

class MarkerDetector {
 public:
  /// Refuses a dictionary that OpenCV does not have.
  [[nodiscard]] static Result<MarkerDetector> create(const std::string& dictionary);
  [[nodiscard]] std::vector<MarkerSighting> detect(const GreyImage& image) const;
  /// The black and white cells of a marker with its border, 255 white, row 0 on top; one pixel a cell.
  [[nodiscard]] Result<GreyImage> pattern(int id) const;

 private:
  struct Dictionary;
  explicit MarkerDetector(std::shared_ptr<const Dictionary> dictionary);
  std::shared_ptr<const Dictionary> dictionary_;
};

/// Pose from all sightings of known markers together. A single marker seen nearly frontally has two poses that fit: the
/// one nearer to `prior` wins, and without a prior the better one, and only if it is clearly better. Nothing when no
/// known marker is seen or the pose is ambiguous.
[[nodiscard]] std::optional<RobustPose> pose_from_markers(const std::vector<MarkerSighting>& sightings,
                                                          const MarkerMap& map, const Camera& camera,
                                                          const std::optional<Pose>& prior);

}  // namespace meshloop
