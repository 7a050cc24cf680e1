#pragma once
// What is fixed about the demo's scene and others have to know.
#include <Eigen/Core>

#include "common/recording/marker_file.h"

namespace meshloop::simulation {

/// The box's move between the two halves of the demo: 2 cm, away from the place where the station starts, so that its
/// front face lies farther away afterwards.
inline const Eigen::Vector3d kBoxMove_m{0.0056, 0.0192, 0.0};

/// The markers printed on the sideboard's top: flat, upper edge towards +y before each one's own turn, z = 0.
[[nodiscard]] MarkerMap demo_markers();

}  // namespace meshloop::simulation
