#pragma once
// From a snapshot (frame, pose, comparison, regions) to proposed edits of the model.
#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/result.h"
#include "common/change/comparison.h"
#include "common/change/region.h"
#include "common/geometry/rig.h"
#include "common/geometry/tracked_pose.h"
#include "common/image/frames.h"
#include "common/mesh/model.h"
#include "server/adjust/depth_fusion.h"

namespace meshloop {

/// All that an adjustment is made from. Pointers must outlive the call.
struct Snapshot {
  const Model* model = nullptr;
  const RgbdFrame* frame = nullptr;
  const Rig* rig = nullptr;
  /// T_depth_world, as the comparison was made with.
  TrackedPose depth_pose;
  /// Where new surface is placed, when something better is known (refine_pose): T_depth_world.
  std::optional<Pose> refined_T_camera_world;
  /// What new surface is made of, when more was measured than this frame (fuse_depth); else the frame's depth.
  const FusedDepth* fused = nullptr;
  const Comparison* comparison = nullptr;
  const RegionMap* regions = nullptr;
};

/// A closed line on the plane of a triangle, in its node's frame.
using PlaneLine = std::vector<Eigen::Vector3d>;
/// By position in a submesh's triangles: the lines around what goes of it. Lines within one another are holes, and run
/// the other way round.
using CutOutlines = std::map<std::uint32_t, std::vector<PlaneLine>>;

/// What goes of a node, by the triangles of its submesh in the snapshot's model.
struct Removal {
  NodeId node = 0;
  /// Of the submesh that the rest is about.
  Hash hash{};
  /// Those that go whole.
  std::vector<bool> triangles;
  /// Those of which a part goes.
  CutOutlines cuts;
  /// Where the node was.
  Pose T_world_node = Pose::Identity();
};

/// A node that belongs to what moves.
struct MovedAlong {
  NodeId node = 0;
  Hash hash{};
  Pose T_world_node = Pose::Identity();
};

/// A node, or a part of it, stands elsewhere now.
struct Move {
  NodeId node = 0;
  /// Of the node's submesh, and where the node was.
  Hash hash{};
  Pose T_world_node = Pose::Identity();
  /// Those of the node's triangles that move; all of them when the node does.
  std::vector<bool> triangles;
  /// The node that they become; 0 when the whole node moves and stays what it is.
  NodeId new_node = 0;
  /// From where they were to where they are, in the world.
  Pose T_world_new_old = Pose::Identity();
  /// 0 to 1: the share of the measurements that the move explains, less where the thing might as well be turned
  /// otherwise.
  double confidence = 0;
  /// Regions that have no proposals of their own for it; not empty.
  std::vector<RegionId> closes;
  /// Other whole nodes that move the same way: patches of the same thing.
  std::vector<MovedAlong> along;
  /// Around all that moves, where it was and where it is, in the world.
  Eigen::AlignedBox3d box_old_m;
  Eigen::AlignedBox3d box_new_m;
};

/// What speaks for a removal: pixels in which the depth camera was expected to see what goes.
struct SeeThrough {
  std::size_t visible = 0;
  /// Of these, with a measurement, and with one behind what goes by more than the threshold.
  std::size_t measured = 0;
  std::size_t seen_through = 0;
  /// By how much, median over the pixels that are seen through: metres, and in sigmas of the sensor's noise at the
  /// measured depth. 0 when none is.
  double behind_m = 0;
  double behind_sigmas = 0;

  /// Of what was visible; what was not measured is not seen through.
  [[nodiscard]] double share() const {
    return visible == 0 ? 0 : static_cast<double>(seen_through) / static_cast<double>(visible);
  }
};

/// One region's change, or a move that is behind several. Ids are regions' ids; a move has the first that it
/// closes, and what it leaves of a closed region has a new one.
struct Proposal {
  RegionId id = 0;
  /// None for a move.
  ChangeKind kind = ChangeKind::none;
  std::optional<Move> move;
  std::vector<Edit> edits;
  std::size_t triangles_added = 0;
  std::size_t triangles_removed = 0;
  /// 0 where the model had nothing to measure it against.
  double largest_change_m = 0;
  /// Around what comes, goes or moves (where it was and where it is), in the world.
  Eigen::AlignedBox3d box_m;
  /// 0 to 1. Of a move: Move::confidence. Of a removal: SeeThrough::share. Of an insertion: how improbable it is that
  /// noise alone makes a pixel differ as much as the region's pixels do on average (Region::significance, normal).
  double confidence = 0;
  /// Of a removal.
  std::optional<SeeThrough> see_through;
  /// Regions that it closes.
  std::vector<RegionId> closes;
  /// "+96 triangles; largest change 21 mm; closes region 4"; "-2 triangles, +14; ..." where large ones were cut;
  /// "moves "box" by 20 mm and 0 degrees; closes regions 4 and 7"
  std::string effect;
  /// For `merge_edits`.
  std::vector<Removal> removed;
};

struct AdjustOptions {
  /// Triangles may span at most this many sigma of depth between neighbouring pixels, beyond what a surface seen at
  /// 80 degrees would show.
  double discontinuity_sigmas = 4;
  /// Connected patches with fewer triangles are dropped: for insertions meant for 640x480 pixels of depth, and scaled
  /// with the area of other images.
  std::size_t min_patch_triangles = 20;
  /// One bilateral pass over the depth of an inserted patch; skipped for sensors with a constant sigma below 1.5 mm.
  bool smooth = true;
  /// Measurements on a plane are put onto it, within the noise, and planes meet in straight lines.
  bool flatten = true;
  /// Where a patch meets the end of a surface of the model, it ends in the same vertices.
  bool stitch = true;
  /// Patches are decimated as long as their surface stays within so many sigma of the sensor's noise; 0: not at all.
  double decimate_sigmas = 0;
  /// And their brightness within so many levels of 255, unless they have a texture.
  double decimate_levels = 12;
  /// Patches get a picture of their colours, as fine as the depth image (ProjectedTexture), in place of a colour for
  /// each vertex: what is decimated keeps its print.
  bool texture = false;
  /// Look for things that moved; else all that moved is removed and inserted.
  bool moves = true;
};

/// Proposals for the confirmed regions: moves first, and what they leave of the regions as insertions and removals.
/// `next_node_id` is the first free id; proposals take consecutive ones. Proposals
/// of one snapshot may be accepted in any subset: edits of the same node are merged by `merge_edits`. None when the
/// depth pose is lost or the snapshot's images do not have the depth camera's size; a region without effect has no
/// proposal.
[[nodiscard]] std::vector<Proposal> propose(const Snapshot& snapshot, NodeId next_node_id,
                                            const AdjustOptions& options);

/// What `apply` takes.
struct MergedEdits {
  std::vector<Edit> edits;
  /// By all of them together: proposals may share a triangle that is cut.
  std::size_t triangles_added = 0;
  std::size_t triangles_removed = 0;
};

/// Edits of several accepted proposals as one list: several removals from one node, and parts that move out of it,
/// become one. Refuses proposals that were made for another revision of the model, and moves that contradict other
/// accepted proposals.
[[nodiscard]] Result<MergedEdits> merge_edits(const Model& model, const std::vector<Proposal>& accepted);

/// The depth grid of a region as a submesh in the world, coloured from the colour image, on the scene's lattice.
/// Positions are the depth pixels, back-projected and carried to the world; colours are looked up where the colour
/// camera sees them (common/geometry/README.md, "From a depth pixel"). A point that the colour camera does not see
/// takes the colour of the nearest one of the patch that it does see, or mid grey. With AdjustOptions::texture these
/// colours are a picture, else one for each vertex. No triangles when nothing is to be inserted.
[[nodiscard]] Submesh insertion_patch(const Snapshot& snapshot, RegionId region, const AdjustOptions& options);

}  // namespace meshloop
