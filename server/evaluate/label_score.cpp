#include "server/evaluate/label_score.h"

#include <cmath>

namespace meshloop {
namespace {

constexpr float kUnchanged_m = 0.001f;

double ratio(std::size_t part, std::size_t whole, double when_empty) {
  return whole == 0 ? when_empty : static_cast<double>(part) / static_cast<double>(whole);
}

std::vector<bool> confirmed_ids(const RegionMap& regions) {
  std::vector<bool> confirmed(1, false);
  for (const auto& region : regions.regions) {
    if (confirmed.size() <= region.id) confirmed.resize(region.id + 1, false);
    confirmed[region.id] = region.confirmed;
  }
  return confirmed;
}

}  // namespace

struct LabelScore::Pixel {
  float measured;
  float expected;
  float threshold_m;
  Label detected;
};

void LabelScore::add(const Comparison& comparison, const RegionMap& regions, const DepthTruth& truth) {
  const auto confirmed = confirmed_ids(regions);
  for (std::size_t i = 0; i < comparison.labels.size(); ++i) {
    const Pixel pixel{truth.measured.pixels()[i], truth.expected.pixels()[i], comparison.threshold_m.pixels()[i],
                      comparison.labels.pixels()[i]};
    if (pixel.detected == Label::unmeasured || pixel.measured == 0) continue;
    const Label label = true_label(pixel);
    count_labels(label, pixel.detected);
    if (is_change(label)) {
      count_recall(pixel, label);
    } else if (std::abs(pixel.measured - pixel.expected) < kUnchanged_m) {
      ++changes_.unchanged;
      const auto region = regions.ids.empty() ? 0 : regions.ids.pixels()[i];
      if (region < confirmed.size() && confirmed[region]) ++changes_.falsely_changed;
    }
  }
}

Label LabelScore::true_label(const Pixel& pixel) const {
  if (pixel.expected == 0) return Label::unmodelled;
  const double difference = pixel.measured - pixel.expected;
  if (std::abs(difference) <= k_ * sensor_.sigma_z_m(pixel.measured, 0)) return Label::agrees;
  return difference < 0 ? Label::closer : Label::farther;
}

void LabelScore::count_labels(Label truth, Label detected) {
  ++counts_[index(truth)].in_truth;
  ++counts_[index(truth)].either;
  if (truth == detected) {
    ++counts_[index(truth)].both;
  } else {
    ++counts_[index(detected)].either;
  }
}

void LabelScore::count_recall(const Pixel& pixel, Label truth) {
  ++changes_.changed;
  if (pixel.detected == Label::undecided) ++changes_.changed_undecided;
  const bool above = truth == Label::unmodelled || std::abs(pixel.measured - pixel.expected) > pixel.threshold_m;
  if (!above) return;
  ++changes_.above_threshold;
  if (kind_of(pixel.detected) == kind_of(truth)) ++changes_.found;
}

double LabelScore::iou(Label label) const {
  return ratio(counts_[index(label)].both, counts_[index(label)].either, 1);
}
double LabelScore::recall() const {
  return ratio(changes_.found, changes_.above_threshold, 1);
}
double LabelScore::false_change() const {
  return ratio(changes_.falsely_changed, changes_.unchanged, 0);
}
double LabelScore::undecided() const {
  return ratio(changes_.changed_undecided, changes_.changed, 0);
}

}  // namespace meshloop
