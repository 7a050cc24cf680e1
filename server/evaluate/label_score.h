#pragma once
// How well labels agree with the truth that a simulator knows.
#include <array>
#include <cstddef>

#include "common/change/comparison.h"
#include "common/change/region.h"
#include "common/geometry/sensor_model.h"
#include "common/image/image.h"

namespace meshloop {

/// The exact depth that the sensor should have measured and the exact depth of the model, at the true pose; 0 for none.
struct DepthTruth {
  DepthImage measured;
  DepthImage expected;
};

/// Sums over frames. Only pixels that the sensor measured count: where nothing was measured nothing can be detected.
///
/// True label of a pixel: `unmodelled` where only the scene has a surface; `closer` or `farther` where both have and
/// the true difference exceeds k sigma of the sensor at that depth; else unchanged.
class LabelScore {
 public:
  /// Pixels that carry a label in the truth and in the detection, in either, and in the truth.
  struct LabelCounts {
    std::size_t both = 0;
    std::size_t either = 0;
    std::size_t in_truth = 0;
  };
  /// The parts of the ratios below, so that several scores can be added up.
  struct ChangeCounts {
    std::size_t changed = 0;
    std::size_t changed_undecided = 0;
    std::size_t above_threshold = 0;
    std::size_t found = 0;
    std::size_t unchanged = 0;
    std::size_t falsely_changed = 0;
  };

  /// k: the true difference that counts as a change, in sigmas of the sensor model.
  LabelScore(SensorModel sensor, double k) : sensor_{sensor}, k_{k} {}

  void add(const Comparison& comparison, const RegionMap& regions, const DepthTruth& truth);

  /// Intersection over union of a label; 1 when neither the truth nor the detection has a pixel of it.
  [[nodiscard]] double iou(Label label) const;
  /// Of the truly changed pixels whose true difference is above the threshold that the comparison stated for them, and
  /// of all truly unmodelled ones: the share that carries the right kind of change.
  [[nodiscard]] double recall() const;
  /// Of the truly unchanged pixels (true difference below 1 mm): the share inside a confirmed region.
  [[nodiscard]] double false_change() const;
  /// Of the truly changed pixels: the share that the comparison left undecided.
  [[nodiscard]] double undecided() const;
  [[nodiscard]] const LabelCounts& counts(Label label) const { return counts_[index(label)]; }
  [[nodiscard]] const ChangeCounts& counts() const { return changes_; }

 private:
  struct Pixel;
  static std::size_t index(Label label) { return static_cast<std::size_t>(label); }
  [[nodiscard]] Label true_label(const Pixel& pixel) const;
  void count_labels(Label truth, Label detected);
  void count_recall(const Pixel& pixel, Label truth);

  SensorModel sensor_;
  double k_;
  std::array<LabelCounts, kLabels.size()> counts_{};
  ChangeCounts changes_;
};

}  // namespace meshloop
