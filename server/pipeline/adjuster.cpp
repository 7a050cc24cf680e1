#include "server/pipeline/adjuster.h"

#include <fmt/format.h>

#include <cmath>

#include "common/base/clock.h"
#include "common/image/image_file.h"
#include "server/adjust/gates.h"

namespace meshloop {
namespace {

// Beyond these a snapshot would place its measurements wrongly by more than the sensor's own noise at 1 m.
constexpr double kMaxPositionSigma_m = 0.004;
constexpr double kMaxSpeed_m_per_s = 0.5;
constexpr double kMaxTurn_rad_per_s = 0.6;

/// Of the depth camera from the frame before to this one; nothing when that is not known.
std::optional<Twist> motion_per_s(const TrackedPose& pose, const std::optional<TrackedPose>& previous) {
  if (!previous || previous->state == TrackState::lost || !(pose.timestamp_s > previous->timestamp_s)) {
    return std::nullopt;
  }
  return log(pose.T_camera_world * previous->T_camera_world.inverse()) / (pose.timestamp_s - previous->timestamp_s);
}

/// Makes the poses of the snapshot and of the frames before it better together, if that can be.
JointPoses refine_views(const Snapshot& snapshot, std::vector<DepthView>& views, Registration& registration) {
  std::vector<PosedDepth> frames;
  for (const auto& view : views) frames.push_back({view.depth, view.T_camera_world, view.covariance, nullptr});
  frames.front().comparison = snapshot.comparison;
  JointPoses joint = refine_poses(frames, snapshot.rig->depth, snapshot.rig->sensor);
  if (joint.refused) return joint;
  for (std::size_t i = 0; i < views.size(); ++i) views[i].T_camera_world = joint.T_camera_world[i];
  registration.T_camera_world = joint.T_camera_world.front();
  registration.refused = std::nullopt;
  return joint;
}

double position_sigma(const TrackedPose& pose) {
  return std::sqrt(pose.covariance.topLeftCorner<3, 3>().trace());
}

/// Refers to what it is made of.
Snapshot snapshot_of(const TrackedFrame& tracked, const Examination& examination, const Rig& rig, const Model& model) {
  return {.model = &model,
          .frame = &tracked.frame,
          .rig = &rig,
          .depth_pose = tracked.depth_pose,
          .refined_T_camera_world = std::nullopt,
          .fused = nullptr,
          .comparison = &examination.comparison,
          .regions = &examination.regions};
}

PoseCheck check_pose(const Snapshot& snapshot, bool has_reference) {
  PoseCheck check;
  const auto object = [&check](PoseGate gate, std::optional<std::string> reason) {
    if (reason && !check.objection) check.objection = PoseObjection{gate, std::move(*reason)};
  };
  check.registration = refine_pose(snapshot);
  object(PoseGate::registration, reason_against_registration(check.registration));
  if (!has_reference) {
    object(PoseGate::unconfirmed, reason_against_unconfirmed(check.registration, *snapshot.model));
  }
  check.rings = find_edge_rings(*snapshot.comparison, snapshot.frame->depth, snapshot.rig->depth, snapshot.rig->sensor);
  object(PoseGate::rings, reason_against_rings(check.rings));
  return check;
}

}  // namespace

std::optional<std::string> reason_against(const TrackedPose& depth_pose) {
  if (depth_pose.state == TrackState::lost) return kPoseIsLost;
  if (!(position_sigma(depth_pose) < kMaxPositionSigma_m)) {
    return fmt::format("the pose is uncertain by {:.1f} mm", 1000 * position_sigma(depth_pose));
  }
  return std::nullopt;
}

std::optional<std::string> reason_against(const TrackedFrame& tracked, const std::optional<TrackedPose>& previous,
                                          const Rig& rig) {
  const TrackedPose& pose = tracked.depth_pose;
  if (auto reason = reason_against(pose)) return reason;
  const CameraMotion motion{motion_per_s(pose, previous),
                            tracked.frame.depth_timestamp_s - tracked.frame.color_timestamp_s};
  return reason_against_motion(motion, tracked.frame.depth, rig);
}

std::optional<std::string> reason_to_wait(const TrackedFrame& tracked, const std::optional<TrackedPose>& previous,
                                          const Rig& rig) {
  if (auto reason = reason_against(tracked, previous, rig)) return reason;
  const auto per_s = motion_per_s(tracked.depth_pose, previous);
  if (!per_s) return "the camera's motion is not known yet";
  if (per_s->head<3>().norm() > kMaxSpeed_m_per_s || per_s->tail<3>().norm() > kMaxTurn_rad_per_s) {
    return "the camera moves too fast";
  }
  return std::nullopt;
}

PoseCheck check_pose(const TrackedFrame& tracked, const Examination& examination, const Rig& rig, const Model& model) {
  return check_pose(snapshot_of(tracked, examination, rig, model), tracked.has_reference);
}

ProposedChanges propose_changes(const TrackedFrame& tracked, const Examination& examination,
                                const std::vector<DepthView>& before, const Rig& rig, const SceneStore& store,
                                const AdjustOptions& options) {
  const auto model = store.model();
  Snapshot snapshot = snapshot_of(tracked, examination, rig, *model);
  auto checked = check_pose(snapshot, tracked.has_reference);
  ProposedChanges changes;
  changes.registration = std::move(checked.registration);
  changes.rings = checked.rings;
  changes.withheld = std::move(checked.objection);
  if (changes.withheld) return changes;
  FusedDepth fused;
  if (!before.empty()) {
    std::vector<DepthView> views{
        {&tracked.frame.depth, tracked.depth_pose.T_camera_world, tracked.depth_pose.covariance}};
    views.insert(views.end(), before.begin(), before.end());
    changes.joint = refine_views(snapshot, views, changes.registration);
    fused = fuse_depth(views, rig.depth, rig.sensor, fused_pixels(examination.regions));
    snapshot.fused = &fused;
    changes.frames = fused.views;
  }
  snapshot.refined_T_camera_world = changes.registration.T_camera_world;
  changes.proposals = propose(snapshot, store.next_node_id(), options);
  return changes;
}

SnapshotInfo snapshot_info(const TrackedFrame& tracked, const Registration& registration,
                           const std::string& calibration) {
  SnapshotInfo info{.calibration = calibration, .depth_pose = tracked.depth_pose, .refined_T_camera_world = {}};
  if (!registration.refused) info.refined_T_camera_world = registration.T_camera_world;
  return info;
}

Result<Acceptance> accept_changes(SceneStore& store, const std::vector<Offered>& accepted, const Evidence& evidence) {
  std::vector<Proposal> proposals;
  for (const auto& offered : accepted) proposals.push_back(offered.proposal);
  const auto merged = merge_edits(*store.model(), proposals);
  if (!merged) return fail(merged.error());
  Acceptance acceptance;
  RevisionInfo& info = acceptance.info;
  info.accepted_ns = wall_clock_ns();
  info.author = evidence.author;
  info.snapshot = evidence.snapshot;
  info.triangles_added = merged->triangles_added;
  info.triangles_removed = merged->triangles_removed;
  for (const auto& [proposal, record] : accepted) {
    if (!info.summary.empty()) info.summary += "; ";
    info.summary += fmt::format("proposal {}: {}", record.id, proposal.effect);
    info.proposals.push_back({record.id, content_of(proposal)});
    if (proposal.move) acceptance.moves.push_back(*proposal.move);
  }
  if (auto png = encode_png(evidence.picture)) info.pictures.push_back(std::move(*png));
  const Stopwatch watch;
  auto model = store.commit_unsynced(merged->edits, info);
  if (!model) return fail(model.error());
  acceptance.commit_ms = watch.milliseconds();
  acceptance.model = std::move(*model);
  info.revision = acceptance.model->revision;
  return acceptance;
}

}  // namespace meshloop
