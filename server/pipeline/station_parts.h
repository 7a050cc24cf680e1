#pragma once
// What a station is made of; for station*.cpp.
#include <optional>
#include <vector>

#include "server/pipeline/change_tally.h"
#include "server/pipeline/operator_commands.h"
#include "server/pipeline/pose_trust.h"
#include "server/pipeline/recent_depths.h"
#include "server/pipeline/region_pictures.h"
#include "server/pipeline/station.h"

namespace meshloop {

struct Station::InFlight {
  TrackedFrame tracked;
  std::shared_ptr<const Model> model;
  /// The event that tells of the frame, as far as it is known.
  nlohmann::json event;
  /// Why the model may not be changed from this frame.
  std::optional<std::string> wait;
  /// Reads the frame and the model, and therefore ends before them.
  std::optional<Examiner::Begun> begun;
};

/// Frames that may be fused with one, from the first that its regions were there.
struct Station::Fusable {
  RecentDepths recent;
  int first = 0;
};

struct Station::Offer {
  TrackedFrame tracked;
  Examination examination;
  Registration registration;
  EdgeRings rings;
  std::optional<JointPoses> joint;
  Fusable fusable;
  /// Why there are no proposals: a gate, or one that fired a moment ago.
  std::optional<std::string> withheld;
  std::size_t frames = 1;
  double snapshot_ms = 0;
  std::vector<Offered> proposals;
};

/// What nothing became of is not proposed again with each frame.
struct Station::Looked {
  std::vector<RegionId> regions;
  double timestamp_s = 0;
};

struct Station::Parts {
  StationOptions options;
  Rig rig;
  std::unique_ptr<GpuContext> gpu;
  Examiner examiner;
  Views views;
  std::unique_ptr<SceneStore> store;
  Publisher publisher;
  std::optional<TrackedPose> previous_pose;
  /// The last revision's picture "after" is still to be made, from the next frame.
  bool after_is_due = false;
  PublishReport last_publish;
  /// When the newest revision was accepted, while it could not be published.
  std::optional<std::int64_t> unpublished_ns;
  RegionPictures region_pictures;
  RecentDepths recent;
  std::unique_ptr<InFlight> in_flight;
  CommandLines commands;
  /// For the operator's commands.
  std::optional<Offer> offer;
  /// The regions of the offer's frame as they were before any of it was accepted.
  RegionMap offered_regions;
  std::optional<Looked> looked;
  PoseTrust trust;
  ChangeTally tally;
  /// That the run began with.
  Revision first_revision = 0;
};

}  // namespace meshloop
