#pragma once
// One frame against the model: compare and regions, joined.
#include <memory>
#include <optional>

#include "server/compare/comparator.h"
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

/// One thread, that of the context.
class Examiner {
 public:
  [[nodiscard]] static Result<Examiner> create(GpuContext& gpu, const Rig& rig, const ExaminerOptions& options);
  /// Refuses a frame whose depth pose is lost. `average` is compared in place of the frame's depth image.
  [[nodiscard]] Result<Examination> examine(const TrackedFrame& frame, const Model& model,
                                            const AveragedDepth* average = nullptr);
  /// The same frame again, after a surface was removed from the model where `removed` has a region that was confirmed:
  /// what stands there now needs no further frames. Only regions of which more than half lies in `removed` are
  /// confirmed.
  [[nodiscard]] Result<Examination> examine_behind(const TrackedFrame& frame, const Model& model,
                                                   const RegionMap& removed);
  /// The regions seen so far were those of another model.
  void model_changed() { regions_.reset(); }

 private:
  Examiner(std::unique_ptr<Comparator> comparator, Rig rig, const ExaminerOptions& options);
  [[nodiscard]] Result<Examination> examine(const TrackedFrame& frame, const Model& model, const AveragedDepth* average,
                                            RegionTracker& regions);

  std::unique_ptr<Comparator> comparator_;
  Rig rig_;
  ExaminerOptions options_;
  RegionTracker regions_;
};

}  // namespace meshloop
