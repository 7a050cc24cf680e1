#pragma once
// How results look as JSON. The keys are a contract: keys are added, never renamed.
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/change/region.h"
#include "common/program/json_output.h"
#include "server/adjust/edge_rings.h"
#include "server/adjust/joint_poses.h"
#include "server/adjust/proposal.h"
#include "server/adjust/registration.h"
#include "server/pipeline/examiner.h"
#include "server/store/scene_store.h"

namespace meshloop {

/// {"min", "max"}, null for an empty box.
[[nodiscard]] nlohmann::json box_json(const Eigen::AlignedBox2i& box);
[[nodiscard]] nlohmann::json box_json(const Eigen::AlignedBox3d& box);
/// `translation` in metres, `rotation_xyzw`.
[[nodiscard]] nlohmann::json pose_json(const Pose& pose);
[[nodiscard]] nlohmann::json counts_json(const Comparison& comparison);
[[nodiscard]] nlohmann::json region_json(const Region& region);
/// Metres, null when nothing can be told.
[[nodiscard]] nlohmann::json smallest_change_json(const Examination& examination);
/// "smallest visible change: 18 mm", for people.
[[nodiscard]] std::string smallest_change_text(const Examination& examination);
/// Why a frame has no smallest change, with what to do.
[[nodiscard]] std::string why_nothing_can_be_told(const Examination& examination);
[[nodiscard]] nlohmann::json times_json(const Examination& examination);
/// How a snapshot's pose was made better.
[[nodiscard]] nlohmann::json registration_json(const Registration& registration, const TrackedPose& pose);
/// What the outlines of the picture say of the pose.
[[nodiscard]] nlohmann::json rings_json(const EdgeRings& rings);
/// How the poses of a snapshot's frames were made better together; null for a single frame.
[[nodiscard]] nlohmann::json joint_json(const std::optional<JointPoses>& joint);
/// Node, those that move along, transform in the world (from where it was to where it is), confidence and the regions
/// that it closes.
[[nodiscard]] nlohmann::json move_json(const Move& move);
/// With the proposals that it accepted. The rig of a snapshot is named by the hash of its text (calibration_name).
[[nodiscard]] nlohmann::json revision_json(const RevisionInfo& info);
[[nodiscard]] std::string calibration_name(const std::string& calibration);

}  // namespace meshloop
