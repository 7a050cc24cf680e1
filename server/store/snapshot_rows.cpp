#include "server/store/snapshot_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/hash.h"
#include "server/store/blobs.h"

namespace meshloop {
namespace {

tl::unexpected<Error> damaged(const Database& database, Revision revision) {
  return fail(fmt::format("'{}' is damaged (the snapshot of revision {} is none); restore it from a copy",
                          database.file().string(), revision));
}

Hash hash_of_text(const std::string& text) {
  return hash_of(std::as_bytes(std::span{text}));
}

std::vector<double> covariance_values(const PoseCovariance& covariance) {
  return {covariance.data(), covariance.data() + covariance.size()};
}

std::optional<PoseCovariance> covariance_from_blob(std::span<const std::byte> blob) {
  PoseCovariance covariance;
  if (blob.size() != static_cast<std::size_t>(covariance.size()) * sizeof(double)) return std::nullopt;
  std::memcpy(covariance.data(), blob.data(), blob.size());
  return covariance.allFinite() ? std::optional{covariance} : std::nullopt;
}

std::optional<TrackState> state_from_name(std::string_view name) {
  for (const TrackState state : {TrackState::tracking, TrackState::relocalised}) {
    if (name_of(state) == name) return state;
  }
  return std::nullopt;
}

/// Columns: timestamp_s, state, pose, covariance, quality, inliers.
std::optional<TrackedPose> pose_of(const Statement& row) {
  const auto state = state_from_name(row.text(1));
  const auto pose = pose_from_blob(row.blob(2));
  const auto covariance = covariance_from_blob(row.blob(3));
  if (!state || !pose || !covariance) return std::nullopt;
  return TrackedPose{row.real(0), *state, *pose, *covariance, row.real(4), static_cast<int>(row.integer(5))};
}

Status check(const SnapshotInfo& snapshot) {
  const TrackedPose& pose = snapshot.depth_pose;
  const bool is_one = pose.state != TrackState::lost && is_rigid(pose.T_camera_world) && pose.covariance.allFinite() &&
                      std::isfinite(pose.timestamp_s) && std::isfinite(pose.quality);
  const bool is_refined_one = !snapshot.refined_T_camera_world || is_rigid(*snapshot.refined_T_camera_world);
  if (is_one && is_refined_one) return {};
  return fail("the snapshot has no pose: it is lost, not rigid, or its covariance or time is not a number");
}

Status append_calibration(Database& database, const Hash& hash, const std::string& rig) {
  auto insert = database.prepare("INSERT INTO calibration VALUES(?, ?) ON CONFLICT DO NOTHING");
  if (!insert) return fail(insert.error());
  return insert->bind(std::as_bytes(std::span{hash})).bind(std::string_view{rig}).run();
}

}  // namespace

Result<std::optional<SnapshotInfo>> read_snapshot(Database& database, Revision revision) {
  auto query = database.prepare(
      "SELECT timestamp_s, state, pose, covariance, quality, inliers, refined_pose, hash, rig "
      "FROM snapshot LEFT JOIN calibration ON hash = calibration WHERE revision = ?");
  if (!query) return fail(query.error());
  const auto row = query->bind(static_cast<std::int64_t>(revision)).step();
  if (!row) return fail(row.error());
  if (!*row) return std::nullopt;
  const auto depth_pose = pose_of(*query);
  SnapshotInfo snapshot;
  if (!query->is_null(6)) snapshot.refined_T_camera_world = pose_from_blob(query->blob(6));
  snapshot.calibration = query->text(8);
  const Hash hash = hash_of_text(snapshot.calibration);
  const auto stored = query->blob(7);
  const auto expected = std::as_bytes(std::span{hash});
  const bool same_calibration = std::equal(stored.begin(), stored.end(), expected.begin(), expected.end());
  if (!depth_pose || !same_calibration || snapshot.refined_T_camera_world.has_value() == query->is_null(6)) {
    return damaged(database, revision);
  }
  snapshot.depth_pose = *depth_pose;
  return snapshot;
}

Status append_snapshot(Database& database, Revision revision, const SnapshotInfo& snapshot) {
  if (auto ok = check(snapshot); !ok) return ok;
  const Hash hash = hash_of_text(snapshot.calibration);
  if (auto ok = append_calibration(database, hash, snapshot.calibration); !ok) return ok;
  auto insert = database.prepare("INSERT INTO snapshot VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?)");
  if (!insert) return fail(insert.error());
  const TrackedPose& pose = snapshot.depth_pose;
  const auto transform = pose_values(pose.T_camera_world);
  const auto covariance = covariance_values(pose.covariance);
  std::vector<double> refined;
  insert->bind(static_cast<std::int64_t>(revision))
      .bind(std::as_bytes(std::span{hash}))
      .bind(pose.timestamp_s)
      .bind(name_of(pose.state))
      .bind(blob_of(transform))
      .bind(blob_of(covariance))
      .bind(pose.quality)
      .bind(static_cast<std::int64_t>(pose.inliers));
  if (snapshot.refined_T_camera_world) {
    refined = pose_values(*snapshot.refined_T_camera_world);
    insert->bind(blob_of(refined));
  } else {
    insert->bind_null();
  }
  return insert->run();
}

}  // namespace meshloop
