#pragma once
// From accepted proposals to a committed revision: adjust and store, joined.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/adjust/edge_rings.h"
#include "server/adjust/joint_poses.h"
#include "server/adjust/proposal.h"
#include "server/adjust/registration.h"
#include "server/pipeline/examiner.h"
#include "server/pipeline/proposal_book.h"
#include "server/store/scene_store.h"

namespace meshloop {

struct Acceptance {
  std::shared_ptr<const Model> model;
  RevisionInfo info;
  double commit_ms = 0;
  std::vector<Move> moves;
};

/// What speaks against a pose (server/adjust/gates.h).
enum class PoseGate { registration, unconfirmed, rings };
inline constexpr std::size_t kPoseGates = 3;
struct PoseObjection {
  PoseGate gate = PoseGate::registration;
  /// One sentence, with what to do.
  std::string reason;
};

/// Whether picture and model agree with the pose of an examined frame.
struct PoseCheck {
  Registration registration;
  EdgeRings rings;
  std::optional<PoseObjection> objection;
};
[[nodiscard]] PoseCheck check_pose(const TrackedFrame& tracked, const Examination& examination, const Rig& rig,
                                   const Model& model);

/// What one examined frame proposes, and how its pose was made better for new surface.
struct ProposedChanges {
  std::vector<Proposal> proposals;
  /// With several frames, the pose that is better for all of them, where there is one.
  Registration registration;
  EdgeRings rings;
  /// Of the frame and those before it; none of a single frame.
  std::optional<JointPoses> joint;
  /// Why nothing is proposed: the picture or the model speaks against the pose.
  std::optional<PoseObjection> withheld;
  /// Of how many frames new surface is made, if any is.
  std::size_t frames = 1;
};
/// `before`: further frames; those that measured another state of the world have no say.
[[nodiscard]] ProposedChanges propose_changes(const TrackedFrame& tracked, const Examination& examination,
                                              const std::vector<DepthView>& before, const Rig& rig,
                                              const SceneStore& store, const AdjustOptions& options);

/// The frame for the journal. `calibration`: TrackedFrames::calibration as rig_text.
[[nodiscard]] SnapshotInfo snapshot_info(const TrackedFrame& tracked, const Registration& registration,
                                         const std::string& calibration);

/// Who accepts, and what there was to see: for the journal.
struct Evidence {
  std::string author;
  SnapshotInfo snapshot;
  ColorImage picture;
};
/// Commits the proposals, which the store knows, as one revision that accepts them, without waiting for the disk
/// (SceneStore::sync does): whoever waits for the change shall not wait for that.
[[nodiscard]] Result<Acceptance> accept_changes(SceneStore& store, const std::vector<Offered>& accepted,
                                                const Evidence& evidence);

inline constexpr const char* kPoseIsLost = "the pose is lost";
/// Why nothing may be written to the model with this pose, or nothing when it may: it is lost or uncertain.
[[nodiscard]] std::optional<std::string> reason_against(const TrackedPose& depth_pose);

/// The same for a frame, and when the camera moved while it was exposed; `previous`, the frame before, tells.
[[nodiscard]] std::optional<std::string> reason_against(const TrackedFrame& tracked,
                                                        const std::optional<TrackedPose>& previous, const Rig& rig);

/// Why a live station waits for a better frame, or nothing when this one will do: reason_against, or a camera that
/// moved too fast since the frame before, or of which that is not known.
[[nodiscard]] std::optional<std::string> reason_to_wait(const TrackedFrame& tracked,
                                                        const std::optional<TrackedPose>& previous, const Rig& rig);

}  // namespace meshloop
