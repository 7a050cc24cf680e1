#pragma once
// One frame against the model: compare and regions, joined.
#include <memory>
#include <optional>
#include <utility>

#include "server/compare/background_comparator.h"
#include "server/compare/frame_average.h"
#include "server/compare/region_tracker.h"
#include "server/pipeline/tracked_frames.h"

namespace meshloop {

struct Examination {
  Comparison comparison;
  /// Comparison::smallest_change_m.
  std::optional<double> smallest_change_m;
  RegionMap regions;
  CompareTimes times;
  double regions_ms = 0;
  /// Of comparison and regions, without waiting in between.
  double total_ms = 0;
};

struct ExaminerOptions {
  Threshold threshold;
  RegionOptions regions;
  /// CompareInput::model_sigma_m.
  double model_sigma_m = 0;
  /// CompareInput::detail_share and wait_for_detail.
  double detail_share = kDetailShare;
  bool wait_for_detail = false;

  /// The regions' significance counts in the threshold's own sigmas.
  static ExaminerOptions of(const Threshold& threshold) {
    ExaminerOptions options;
    options.threshold = threshold;
    if (threshold.kind == Threshold::Kind::k_sigma) options.regions.sigmas_per_threshold = threshold.value;
    return options;
  }
};

/// The comparison runs on a thread of its own, regions on the caller's. One thread.
class Examiner {
 public:
  [[nodiscard]] static Result<Examiner> create(const Rig& rig, const ExaminerOptions& options);

  /// A frame that is being compared.
  struct Begun {
    const TrackedFrame* frame = nullptr;
    const AveragedDepth* average = nullptr;
    PendingComparison comparison;
  };
  /// Does not wait. `average` is compared in place of the frame's depth image. All three must stay as they are until
  /// the frame is finished or given up. Refused, with `finish`, is a frame whose depth pose is lost.
  [[nodiscard]] Begun begin(const TrackedFrame& frame, const Model& model, const AveragedDepth* average = nullptr);
  /// Waits for the comparison. In the order of `begin`.
  [[nodiscard]] Result<Examination> finish(Begun begun) { return finish(std::move(begun), regions_); }
  /// Both at once.
  [[nodiscard]] Result<Examination> examine(const TrackedFrame& frame, const Model& model);
  /// The same frame again, after a surface was removed from the model where `removed` has a region that was confirmed:
  /// what stands there now needs no further frames. Only regions of which more than half lies in `removed` are
  /// confirmed.
  [[nodiscard]] Result<Examination> examine_behind(const TrackedFrame& frame, const Model& model,
                                                   const RegionMap& removed);
  /// The same frame again after any change of the model: only regions of which more than half lies where `before` has
  /// a region that was confirmed are confirmed.
  [[nodiscard]] Result<Examination> examine_again(const TrackedFrame& frame, const Model& model,
                                                  const RegionMap& before);
  /// The regions seen so far were those of another model.
  void model_changed() { regions_.reset(); }

 private:
  Examiner(std::unique_ptr<BackgroundComparator> comparator, Rig rig, const ExaminerOptions& options);
  [[nodiscard]] Result<Examination> finish(Begun begun, RegionTracker& regions);
  [[nodiscard]] Result<Examination> examine_inside(const TrackedFrame& frame, const Model& model,
                                                   const RegionMap& before, bool removals_only);

  std::unique_ptr<BackgroundComparator> comparator_;
  Rig rig_;
  ExaminerOptions options_;
  RegionTracker regions_;
};

}  // namespace meshloop
