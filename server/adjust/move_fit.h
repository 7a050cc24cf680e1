#pragma once
// Where a part stands, by what is measured.
#include <Eigen/Core>
#include <cstddef>

#include "server/adjust/without_part.h"

namespace meshloop::adjust {

struct MoveFit {
  Pose T_camera_node = Pose::Identity();
  /// Of what of the part faces the camera: the share (as seen) that loose measurements agree with.
  double agreeing = 0;
  /// The pose is free along as many directions as neither faces nor outline hold; they keep what they started with.
  int free_directions = 0;
  /// One of them shifts the part rather than turning it.
  bool slides = false;
};

/// Point-to-plane ICP (Chen and Medioni 1992) of the part's surface to the loose measurements behind its points, with
/// Tukey's weights from 8 cm down to 5 sigma. `points` of the part's are used.
[[nodiscard]] MoveFit fit_faces(const MoveScene& scene, const Part& part, const WithoutPart& without, const Pose& start,
                                std::size_t points);

/// The same with all points, and the outline: where the part's edge is seen before something farther away, the edge of
/// the loose measurements is looked for across it, as trackers of models do in colour images (Drummond and Cipolla
/// 2002). It holds what the faces alone let slide.
[[nodiscard]] MoveFit fit_outline(const MoveScene& scene, const Part& part, const WithoutPart& without,
                                  const Pose& start);

}  // namespace meshloop::adjust
