#pragma once
// From where a part's new place is looked for, and where it would look the same.
#include <vector>

#include "server/adjust/without_part.h"

namespace meshloop::adjust {

/// T_camera_node: where the part was; and before each loose piece of about its size, turned by steps of 30 degrees
/// about each of its axes, so that what faces the camera lies on the piece's middle.
[[nodiscard]] std::vector<Pose> starts_of(const MoveScene& scene, const Part& part, const WithoutPart& without);

/// How far a thing goes from one pose to the other: way of its middle, and its radius times the angle, metres.
[[nodiscard]] double way_m(const Part& part, const Pose& from, const Pose& to);

/// The pose first; then those turned as a cube, and unturned from the part's old place, at which what is seen of the
/// part is the same, to the tolerance.
[[nodiscard]] std::vector<Pose> look_alikes(const MoveScene& scene, const Part& part, const Pose& T_camera_node);

}  // namespace meshloop::adjust
