#pragma once
// A scene is one SQLite file. What was reported as committed survives the end of the process at any moment.
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/geometry/tracked_pose.h"
#include "common/image/image.h"
#include "common/mesh/model.h"
#include "server/store/proposal_record.h"

namespace meshloop {

/// What a change was measured with.
struct SnapshotInfo {
  /// The rig as calibrated: the text of a rig.yaml. The file holds each text once.
  std::string calibration;
  /// T_depth_world at the depth image's time, as the comparison was made with; not lost, its covariance finite.
  TrackedPose depth_pose;
  /// T_depth_world that new surface was placed with, where a better one than depth_pose was found.
  std::optional<Pose> refined_T_camera_world;
};

/// Who, when and why, kept with every revision.
struct RevisionInfo {
  Revision revision = 0;
  /// The revision it was made from.
  Revision parent = 0;
  /// Since 1970 (UTC).
  std::int64_t accepted_ns = 0;
  /// Who accepted it.
  std::string author;
  std::string summary;
  std::size_t triangles_added = 0;
  std::size_t triangles_removed = 0;
  /// PNG files' bytes: the snapshot's pictures (may be empty).
  std::vector<std::vector<std::byte>> pictures;
  /// Nothing for changes that were not measured (import, undo, redo, restore) and in scenes of schema version 1.
  std::optional<SnapshotInfo> snapshot;
  /// That the revision accepts, by id; they must be known and not be accepted yet. None for import, undo, redo, restore
  /// and in scenes before schema version 3.
  std::vector<AcceptedProposal> proposals;
};

/// All functions may be called from any thread. Several processes may read one scene; the first that writes (commit,
/// undo, redo, restore, begin_epoch) is its only writer until it closes the store or dies: the others' writes are
/// errors then. An error leaves the scene at its last revision.
class SceneStore {
 public:
  /// Creates the file when it is not there. A damaged or foreign file is refused, unchanged. Where it or its
  /// folder may not be written the scene can be read; a reading while another program writes is an error.
  [[nodiscard]] static Result<std::unique_ptr<SceneStore>> open(const std::filesystem::path& file, bool create);
  virtual ~SceneStore() = default;

  [[nodiscard]] virtual std::shared_ptr<const Model> model() const = 0;
  /// First id that no node of any revision has used.
  [[nodiscard]] virtual NodeId next_node_id() const = 0;

  /// Applies the edits as a new revision after the present one and returns when it is on the disk. Revisions after the
  /// present one (undone ones) stay in the journal, but redo no longer reaches them. The info's revision and parent are
  /// filled in by the store, accepted_ns too where it is 0. Its proposals become accepted ones in the same transaction.
  /// Refuses to add a node under an id that any revision used, a snapshot whose pose is none, and a proposal that is
  /// unknown or was accepted.
  [[nodiscard]] virtual Result<std::shared_ptr<const Model>> commit(const std::vector<Edit>& edits,
                                                                    RevisionInfo info) = 0;

  /// The same, without waiting for the disk: the revision survives the end of this process at any moment, but the loss
  /// of power only after `sync`. If power is lost before, its number is given again, in a later epoch.
  [[nodiscard]] virtual Result<std::shared_ptr<const Model>> commit_unsynced(const std::vector<Edit>& edits,
                                                                             RevisionInfo info) = 0;
  /// Returns when everything that was committed is on the disk; other calls wait meanwhile. An error is final: nobody
  /// can tell what the disk has then, and the store takes no more changes.
  [[nodiscard]] virtual Status sync() = 0;

  /// One step back, one step forth again. They are new revisions too: numbers only grow, so that devices never see one
  /// number with two contents. Undo opens the proposals again that the change accepted, redo closes them again.
  /// Refused where there is nothing to undo or redo, and a redo that would accept what was rejected since.
  [[nodiscard]] virtual Result<std::shared_ptr<const Model>> undo(const std::string& author) = 0;
  [[nodiscard]] virtual Result<std::shared_ptr<const Model>> redo(const std::string& author) = 0;

  /// The revision whose content undo or redo would show (0: the empty scene); nothing where there is nothing to undo
  /// or redo.
  [[nodiscard]] virtual Result<std::optional<Revision>> shown_by_undo() const = 0;
  [[nodiscard]] virtual Result<std::optional<Revision>> shown_by_redo() const = 0;

  /// The content of any revision again, undone ones and 0 (the empty scene) included, as a new revision. It is a change
  /// like an accepted one: undo takes it back, redo after that brings it again, and redo no longer reaches what was
  /// undone before it. The journal's triangles are the net of each node. Proposals stay as they are. Refuses a revision
  /// that is not there, and one that the present content equals bit for bit.
  [[nodiscard]] virtual Result<std::shared_ptr<const Model>> restore(Revision revision, const std::string& author) = 0;

  /// Oldest first.
  [[nodiscard]] virtual Result<std::vector<RevisionInfo>> log() const = 0;
  /// The model as it was at a revision, bit for bit.
  [[nodiscard]] virtual Result<std::shared_ptr<const Model>> model_at(Revision revision) const = 0;

  /// All that were ever remembered, by id.
  [[nodiscard]] virtual Result<std::vector<ProposalRecord>> proposals() const = 0;
  /// Remembers what a snapshot proposes and gives ids, in the order of the sightings. A known open one takes the new
  /// content, a rejected one keeps its own. Does not wait for the disk (sync does). Refuses a known id that is unknown
  /// or was accepted, and an empty box.
  [[nodiscard]] virtual Result<std::vector<ProposalId>> remember(const std::vector<ProposalSighting>& seen) = 0;
  /// Returns when it is on the disk. Refuses ids that are unknown or were accepted; then none is rejected.
  [[nodiscard]] virtual Status reject(const std::vector<ProposalId>& ids, const std::string& author,
                                      const std::string& reason) = 0;

  /// A number that grows by one with each call and survives restarts: the station's start counter.
  [[nodiscard]] virtual Result<std::uint64_t> begin_epoch() = 0;
};

}  // namespace meshloop
