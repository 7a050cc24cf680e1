#include "server/pipeline/examiner.h"

#include <algorithm>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/base/clock.h"

namespace meshloop {
namespace {

/// Whether each region id of a map is confirmed, and a removal where only those are asked for.
std::vector<bool> confirmed_ones(const RegionMap& map, bool removals_only) {
  std::vector<bool> confirmed(1, false);
  for (const auto& region : map.regions) {
    confirmed.resize(std::max<std::size_t>(confirmed.size(), region.id + 1), false);
    confirmed[region.id] = region.confirmed && (!removals_only || region.kind == ChangeKind::removal);
  }
  return confirmed;
}

void keep_confirmed_inside(const RegionMap& removed, bool removals_only, RegionMap& behind) {
  const auto was_removed = confirmed_ones(removed, removals_only);
  std::unordered_map<RegionId, int> inside;
  for (std::size_t i = 0; i < behind.ids.size(); ++i) {
    const RegionId before = removed.ids.pixels()[i];
    if (behind.ids.pixels()[i] != 0 && before < was_removed.size() && was_removed[before])
      ++inside[behind.ids.pixels()[i]];
  }
  for (auto& region : behind.regions) region.confirmed = region.confirmed && 2 * inside[region.id] > region.pixels;
}

const DepthImage& measured_by(const TrackedFrame& frame, const AveragedDepth* average) {
  return average != nullptr ? average->mean : frame.frame.depth;
}

}  // namespace

Examiner::Examiner(std::unique_ptr<BackgroundComparator> comparator, Rig rig, const ExaminerOptions& options)
    : comparator_{std::move(comparator)}, rig_{std::move(rig)}, options_{options}, regions_{options.regions} {}

Result<Examiner> Examiner::create(const Rig& rig, const ExaminerOptions& options) {
  auto comparator = BackgroundComparator::create();
  if (!comparator) return fail(comparator.error());
  return Examiner{std::move(*comparator), rig, options};
}

Examiner::Begun Examiner::begin(const TrackedFrame& frame, const Model& model, const AveragedDepth* average) {
  const CompareInput input{.model = &model,
                           .camera = rig_.depth,
                           .sensor = rig_.sensor,
                           .intrinsics_covariance = rig_.covariance.depth_intrinsics,
                           .pose = frame.depth_pose,
                           .measured = &measured_by(frame, average),
                           .frames_averaged = average != nullptr ? &average->frames : nullptr,
                           .model_sigma_m = options_.model_sigma_m,
                           .threshold = options_.threshold,
                           .detail_share = options_.detail_share,
                           .wait_for_detail = options_.wait_for_detail};
  return {&frame, average, comparator_->begin(input)};
}

Result<Examination> Examiner::finish(Begun begun, RegionTracker& regions) {
  auto compared = begun.comparison.take();
  if (!compared) return fail(compared.error());
  Examination examination;
  examination.comparison = std::move(compared->comparison);
  examination.times = compared->times;
  const Stopwatch watch;
  examination.smallest_change_m = examination.comparison.smallest_change_m();
  const int frames = begun.average != nullptr ? begun.average->count : 1;
  examination.regions = regions.update(examination.comparison, measured_by(*begun.frame, begun.average), rig_.depth,
                                       begun.frame->depth_pose.T_camera_world, frames);
  settle_labels(examination.comparison, examination.regions);
  examination.regions_ms = watch.milliseconds();
  examination.total_ms = compared->total_ms + examination.regions_ms;
  return examination;
}

Result<Examination> Examiner::examine(const TrackedFrame& frame, const Model& model) {
  return finish(begin(frame, model));
}

Result<Examination> Examiner::examine_behind(const TrackedFrame& frame, const Model& model, const RegionMap& removed) {
  return examine_inside(frame, model, removed, true);
}

Result<Examination> Examiner::examine_again(const TrackedFrame& frame, const Model& model, const RegionMap& before) {
  return examine_inside(frame, model, before, false);
}

Result<Examination> Examiner::examine_inside(const TrackedFrame& frame, const Model& model, const RegionMap& before,
                                             bool removals_only) {
  RegionOptions options = options_.regions;
  options.confirm_views = 1;
  RegionTracker regions{options};
  auto examination = finish(begin(frame, model), regions);
  if (examination) keep_confirmed_inside(before, removals_only, examination->regions);
  return examination;
}

}  // namespace meshloop
