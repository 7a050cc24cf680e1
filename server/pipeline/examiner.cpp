#include "server/pipeline/examiner.h"

#include <utility>

#include "common/base/clock.h"

namespace meshloop {

Examiner::Examiner(std::unique_ptr<Comparator> comparator, Rig rig, const ExaminerOptions& options)
    : comparator_{std::move(comparator)}, rig_{std::move(rig)}, options_{options}, regions_{options.regions} {}

Result<Examiner> Examiner::create(GpuContext& gpu, const Rig& rig, const ExaminerOptions& options) {
  auto comparator = Comparator::create(gpu);
  if (!comparator) return fail(comparator.error());
  return Examiner{std::move(*comparator), rig, options};
}

Result<Examination> Examiner::examine(const TrackedFrame& frame, const Model& model) {
  const Stopwatch total;
  Examination examination;
  const CompareInput input{.model = &model,
                           .camera = rig_.depth,
                           .sensor = rig_.sensor,
                           .pose = frame.depth_pose,
                           .measured = &frame.frame.depth,
                           .threshold = options_.threshold};
  auto comparison = comparator_->compare(input, &examination.times);
  if (!comparison) return fail(comparison.error());
  examination.comparison = std::move(*comparison);

  const Stopwatch regions;
  examination.regions =
      regions_.update(examination.comparison, frame.frame.depth, rig_.depth, frame.depth_pose.T_camera_world);
  settle_labels(examination.comparison, examination.regions);
  examination.regions_ms = regions.milliseconds();
  examination.total_ms = total.milliseconds();
  return examination;
}

}  // namespace meshloop
