#include "server/pipeline/result_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "common/base/hash.h"
#include "server/compare/compare_input.h"
#include "server/pipeline/proposal_json.h"

namespace meshloop {
namespace {

template <class Box>
nlohmann::json any_box_json(const Box& box) {
  if (box.isEmpty()) return nullptr;
  const auto list = [](const auto& corner) { return std::vector(corner.begin(), corner.end()); };
  return {{"min", list(box.min())}, {"max", list(box.max())}};
}

/// The upper triangle, row by row, as rig.yaml has covariances.
nlohmann::json covariance_json(const PoseCovariance& covariance) {
  nlohmann::json json = nlohmann::json::array();
  for (Eigen::Index row = 0; row < 6; ++row) {
    for (Eigen::Index column = row; column < 6; ++column) json.push_back(covariance(row, column));
  }
  return json;
}

nlohmann::json snapshot_json(const SnapshotInfo& snapshot) {
  const TrackedPose& pose = snapshot.depth_pose;
  nlohmann::json refined = nullptr;
  if (snapshot.refined_T_camera_world) refined = pose_json(snapshot.refined_T_camera_world->inverse());
  return {{"timestamp", pose.timestamp_s},
          {"state", name_of(pose.state)},
          {"T_world_depth", pose_json(pose.T_camera_world.inverse())},
          {"covariance", covariance_json(pose.covariance)},
          {"quality", pose.quality},
          {"inliers", pose.inliers},
          {"refined_T_world_depth", refined},
          {"calibration", calibration_name(snapshot.calibration)}};
}

}  // namespace

nlohmann::json box_json(const Eigen::AlignedBox2i& box) {
  return any_box_json(box);
}

nlohmann::json box_json(const Eigen::AlignedBox3d& box) {
  return any_box_json(box);
}

nlohmann::json pose_json(const Pose& pose) {
  const Eigen::Vector3d t = pose.translation();
  const Eigen::Quaterniond q = Eigen::Quaterniond(pose.linear()).normalized();
  return {{"translation", {t.x(), t.y(), t.z()}}, {"rotation_xyzw", {q.x(), q.y(), q.z(), q.w()}}};
}

nlohmann::json counts_json(const Comparison& comparison) {
  nlohmann::json json;
  const auto counts = comparison.counts();
  for (const auto& label : kLabels) json[std::string(label.name)] = counts[static_cast<std::size_t>(label.label)];
  return json;
}

nlohmann::json region_json(const Region& region) {
  return {{"id", region.id},
          {"kind", region.kind == ChangeKind::insertion ? "insertion" : "removal"},
          {"pixels", region.pixels},
          {"area_m2", region.area_m2},
          {"mean_difference_m", region.mean_difference_m},
          {"max_difference_m", region.max_difference_m},
          {"significance", region.significance},
          {"box_px", box_json(region.pixel_box)},
          {"box_m", box_json(region.world_box)},
          {"centre_m", std::vector(region.centre_m.begin(), region.centre_m.end())},
          {"frames_seen", region.frames_seen},
          {"views_seen", region.views_seen},
          {"confirmed", region.confirmed}};
}

nlohmann::json smallest_change_json(const Examination& examination) {
  if (!examination.smallest_change_m) return nullptr;
  return *examination.smallest_change_m;
}

std::string smallest_change_text(const Examination& examination) {
  if (!examination.smallest_change_m) return "no change can be told";
  const double mm = 1000 * *examination.smallest_change_m;
  return fmt::format("smallest visible change: {:.{}f} mm", mm, mm < 10 ? 1 : 0);
}

std::string why_nothing_can_be_told(const Examination& examination) {
  const auto differences = examination.comparison.difference_m.pixels();
  if (std::all_of(differences.begin(), differences.end(), [](float difference) { return std::isnan(difference); })) {
    return "nothing is both measured and modelled: do the model, the poses and depth_scale fit the recording?";
  }
  return fmt::format(
      "nothing can be told at this threshold, which is above {} m at half of the pixels or more: lower --threshold or "
      "--model-sigma",
      kLargestThreshold_m);
}

nlohmann::json times_json(const Examination& examination) {
  const auto& times = examination.times;
  return {{"upload", times.upload_ms},         {"render", times.render_ms},     {"compare", times.compare_ms},
          {"regions", examination.regions_ms}, {"readback", times.readback_ms}, {"total", examination.total_ms}};
}

nlohmann::json registration_json(const Registration& registration, const TrackedPose& pose) {
  Twist correction = Twist::Zero();
  if (!registration.refused) correction = log(registration.T_camera_world * pose.T_camera_world.inverse());
  const nlohmann::json refused = registration.refused ? nlohmann::json(*registration.refused) : nlohmann::json(nullptr);
  return {{"refused", refused},
          {"correction_m", correction.head<3>().norm()},
          {"correction_degrees", correction.tail<3>().norm() * 180 / std::numbers::pi},
          {"distance_m", {{"before", registration.before_m}, {"after", registration.after_m}}},
          {"agreeing_points", registration.points},
          {"points", registration.looked_at},
          {"held_directions", registration.held_directions},
          {"model_asks_for_m", registration.found.head<3>().norm()},
          {"model_asks_for_degrees", registration.found.tail<3>().norm() * 180 / std::numbers::pi},
          {"disagreement_sigmas", registration.disagreement_sigmas},
          {"share_agreeing", registration.share_agreeing},
          {"share_nearer", registration.share_nearer}};
}

nlohmann::json rings_json(const EdgeRings& rings) {
  return {{"outlines", rings.outlines},
          {"at_place", rings.at_place},
          {"ringed_closer", rings.ringed_closer},
          {"ringed_farther", rings.ringed_farther},
          {"motion_m", rings.motion.head<3>().norm()},
          {"motion_degrees", rings.motion.tail<3>().norm() * 180 / std::numbers::pi},
          {"shifted", rings.shifted},
          {"explained", rings.explained},
          {"contradicted", rings.contradicted},
          {"things", rings.things},
          {"largest_thing", rings.largest_thing}};
}

nlohmann::json joint_json(const std::optional<JointPoses>& joint) {
  if (!joint) return nullptr;
  const auto distances_json = [](double before, double after) {
    return nlohmann::json{{"before", before}, {"after", after}};
  };
  const nlohmann::json refused = joint->refused ? nlohmann::json(*joint->refused) : nlohmann::json(nullptr);
  return {{"refused", refused},
          {"frames", joint->T_camera_world.size()},
          {"distance_from_model_m", distances_json(joint->before.model_m, joint->after.model_m)},
          {"distance_between_frames_m", distances_json(joint->before.frames_m, joint->after.frames_m)},
          {"pieces_on_model", joint->on_model},
          {"pieces_between_frames", joint->between_frames},
          {"held_by_model", joint->held_by_model},
          {"held_by_frames", joint->held_by_frames}};
}

nlohmann::json move_json(const Move& move) {
  nlohmann::json along = nlohmann::json::array();
  for (const auto& other : move.along) along.push_back(other.node);
  const nlohmann::json new_node = move.new_node == 0 ? nlohmann::json(nullptr) : nlohmann::json(move.new_node);
  return {{"node", move.node},
          {"new_node", new_node},
          {"along", along},
          {"T_world_new_old", pose_json(move.T_world_new_old)},
          {"confidence", move.confidence},
          {"closes", move.closes}};
}

nlohmann::json revision_json(const RevisionInfo& info) {
  nlohmann::json proposals = nlohmann::json::array();
  for (const auto& proposal : info.proposals) proposals.push_back(proposal_json(proposal));
  return {{"revision", info.revision},
          {"parent", info.parent},
          {"accepted_ns", info.accepted_ns},
          {"author", info.author},
          {"summary", info.summary},
          {"triangles_added", info.triangles_added},
          {"triangles_removed", info.triangles_removed},
          {"pictures", info.pictures.size()},
          {"proposals", proposals},
          {"snapshot", info.snapshot ? snapshot_json(*info.snapshot) : nlohmann::json(nullptr)}};
}

std::string calibration_name(const std::string& calibration) {
  return to_hex(hash_of(std::as_bytes(std::span{calibration})));
}

}  // namespace meshloop
