#pragma once
// Whether a snapshot may change the model at all: where it was taken from must be right.
#include <optional>
#include <string>

#include "common/geometry/rig.h"
#include "server/adjust/edge_rings.h"
#include "server/adjust/registration.h"

namespace meshloop {

/// What the camera did around a snapshot.
struct CameraMotion {
  /// Of points in the depth camera's frame, a second; nothing when it is not known.
  std::optional<Twist> per_s;
  /// From the colour image's exposure to the depth image's, seconds; of either sign.
  double between_exposures_s = 0;
};

/// Each says, in one sentence with what to do, why nothing may be written to the model from a snapshot; nothing when it
/// has nothing against it. Removals and moves are withheld as well as insertions: all are placed by the same pose.

/// While its depth was exposed (a sixtieth of a second), the camera moved what it sees by more than three sigma of
/// a measurement, of its depth and the width of a pixel; or between both exposures by more than four pixels of the
/// colour image.
[[nodiscard]] std::optional<std::string> reason_against_motion(const CameraMotion& motion, const DepthImage& depth,
                                                               const Rig& rig);
/// What has not changed asks for a pose that lies beside the snapshot's by more than five sigma of both, half of the
/// model's surface agrees there, and nearly all that tells both poses apart is nearer to it (Registration).
[[nodiscard]] std::optional<std::string> reason_against_registration(const Registration& registration);
/// Of a pose that goes back to one that was given, and to nothing that was seen since: hardly any of the model confirms
/// it (less than a fifth of what is expected, or 100 points). A model without triangles need not.
[[nodiscard]] std::optional<std::string> reason_against_unconfirmed(const Registration& registration,
                                                                    const Model& model);
/// Outlines all over the picture are ringed, closer on one side and farther on the other (EdgeRings).
[[nodiscard]] std::optional<std::string> reason_against_rings(const EdgeRings& rings);

}  // namespace meshloop
