#include "server/show/legend.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "server/show/blend.h"
#include "server/show/text.h"

namespace meshloop::show {
namespace {

constexpr Rgb8 kBackground{28, 30, 34};
constexpr Rgb8 kInk{235, 235, 235};
constexpr Rgb8 kFaintInk{165, 168, 175};
constexpr Rgb8 kMidGrey{128, 128, 128};

struct Entry {
  Rgb8 color;
  std::string name;
  std::string meaning;
};

std::vector<Entry> entries_of(const std::array<bool, kLabels.size()>& shown, const OverlayOptions& options) {
  std::vector<Entry> entries;
  for (const auto& label : kLabels) {
    if (label.opacity == Opacity::transparent || !shown[static_cast<std::size_t>(label.label)]) continue;
    entries.push_back({color_of(label.label, options.palette), std::string{label.name}, std::string{label.meaning}});
  }
  return entries;
}

/// Numbers along the bar: millimetres, or metres where these would be thousands.
struct BarUnit {
  const char* name;
  double per_m;
};

BarUnit bar_unit(const OverlayOptions& options) {
  return bar_end_m(options) < 0.999 ? BarUnit{"mm", 1000} : BarUnit{"m", 1};
}

/// "+12.5", "-1000": three digits that say something, never an exponent.
std::string tick_text(double value) {
  if (value == 0) return "0";
  return std::abs(value) < 999.5 ? fmt::format("{:+.3g}", value) : fmt::format("{:+.0f}", value);
}

/// Draws from the top down; with a null image it only measures.
class Layout {
 public:
  Layout(int width, cv::Mat* image)
      : pen_{std::clamp(width / 800.0, 1.0, 2.0)}, width_{width}, margin_{pen_.px(12)}, y_{pen_.px(8)}, image_{image} {}

  void title(const std::string& text) {
    if (text.empty()) return;
    std::string line = text;
    while (line.size() > 4 && pen_.size_of(line).width > width_ - 2 * margin_)
      line.erase(line.size() - 4).append("...");
    write(line, margin_, y_ + pen_.px(14), kInk);
    y_ += pen_.px(24);
  }

  void swatches(const std::vector<Entry>& entries) {
    std::vector<int> widths = column_widths(entries);
    const int columns = static_cast<int>(widths.size());
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const auto column = static_cast<std::ptrdiff_t>(i) % columns;
      const int row = static_cast<int>(i) / columns;
      const int x = margin_ + std::accumulate(widths.begin(), widths.begin() + column, 0);
      swatch(entries[i], x, y_ + row * pen_.px(21));
    }
    const int rows = (static_cast<int>(entries.size()) + columns - 1) / columns;
    y_ += rows * pen_.px(21);
    if (!entries.empty()) return;
    write("no difference to be shown", margin_, y_ + pen_.px(13), kFaintInk);
    y_ += pen_.px(21);
  }

  void bar(const OverlayOptions& options) {
    const std::string caption = fmt::format("measured - model, {}", bar_unit(options).name);
    const std::string nearer{info(Label::closer).name};
    const std::string beyond{info(Label::farther).name};
    const int left = margin_ + pen_.size_of(caption).width + pen_.size_of(nearer).width + pen_.px(28);
    const int right = width_ - margin_ - pen_.size_of(beyond).width - pen_.px(10);
    y_ += pen_.px(5);
    const int height = pen_.px(14);
    write(caption, margin_, y_ + pen_.px(12), kFaintInk);
    write(nearer, left - pen_.size_of(nearer).width - pen_.px(10), y_ + pen_.px(12), kInk);
    write(beyond, right + pen_.px(10), y_ + pen_.px(12), kInk);
    ramp(cv::Rect{left, y_, right - left, height}, options);
    y_ += height;
    ticks(left, right, options);
    y_ += pen_.px(26);
  }

  [[nodiscard]] int height() const { return y_; }

 private:
  [[nodiscard]] int entry_width(const Entry& e) const {
    return pen_.px(24) + pen_.size_of(e.name).width + pen_.px(8) + pen_.size_of(e.meaning).width;
  }

  // As many columns as fit, each as wide as its widest entry and a gap; at least one.
  [[nodiscard]] std::vector<int> column_widths(const std::vector<Entry>& entries) const {
    const int gap = pen_.px(22);
    for (std::size_t columns = std::max<std::size_t>(entries.size(), 1);; --columns) {
      std::vector<int> widths(columns, gap);
      for (std::size_t i = 0; i < entries.size(); ++i) {
        widths[i % columns] = std::max(widths[i % columns], entry_width(entries[i]) + gap);
      }
      const int all = std::accumulate(widths.begin(), widths.end(), 0) - gap;
      if (columns == 1 || all <= width_ - 2 * margin_) return widths;
    }
  }

  void write(const std::string& text, int x, int y, Rgb8 color) {
    if (image_) pen_.write(*image_, text, {x, y}, color);
  }

  void swatch(const Entry& e, int x, int y) {
    if (image_) {
      const cv::Rect box{x, y + pen_.px(2), pen_.px(16), pen_.px(13)};
      cv::rectangle(*image_, box, scalar(e.color), cv::FILLED);
      cv::rectangle(*image_, box, scalar(kInk), 1);
    }
    write(e.name, x + pen_.px(24), y + pen_.px(13), kInk);
    write(e.meaning, x + pen_.px(32) + pen_.size_of(e.name).width, y + pen_.px(13), kFaintInk);
  }

  void ramp(const cv::Rect& box, const OverlayOptions& options) {
    if (!image_) return;
    const double end = bar_end_m(options);
    const Paint paint{options};
    for (int x = 0; x < box.width; ++x) {
      const double difference = (2.0 * x / std::max(1, box.width - 1) - 1) * end;
      const bool is_shown = std::abs(difference) >= options.smallest_change_m;
      const Label label = !is_shown ? Label::agrees : difference < 0 ? Label::closer : Label::farther;
      const Rgb8 color = paint.cover(kMidGrey, label, static_cast<float>(difference));
      cv::line(*image_, {box.x + x, box.y}, {box.x + x, box.y + box.height - 1}, scalar(color));
    }
    cv::rectangle(*image_, {box.x - 1, box.y - 1, box.width + 2, box.height + 2}, scalar(kFaintInk), 1);
  }

  void ticks(int left, int right, const OverlayOptions& options) {
    const double end = bar_end_m(options) * bar_unit(options).per_m;
    for (int k = -2; k <= 2; ++k) {
      const int x = left + (right - 1 - left) * (k + 2) / 4;
      if (image_) cv::line(*image_, {x, y_}, {x, y_ + pen_.px(4)}, scalar(kInk));
      const auto text = tick_text(end * k / 2);
      write(text, x - pen_.size_of(text).width / 2, y_ + pen_.px(18), kInk);
    }
  }

  Pen pen_;
  int width_;
  int margin_;
  int y_;
  cv::Mat* image_;
};

void lay_out(Layout& layout, const std::vector<Entry>& entries, const OverlayOptions& options) {
  layout.title(options.title);
  layout.swatches(entries);
  layout.bar(options);
}

}  // namespace

ColorImage draw_legend(int width, const std::array<bool, kLabels.size()>& shown, const OverlayOptions& options) {
  const auto entries = entries_of(shown, options);
  Layout measure{width, nullptr};
  lay_out(measure, entries, options);
  ColorImage legend{width, measure.height(), kBackground};
  cv::Mat image = wrap(legend);
  Layout draw{width, &image};
  lay_out(draw, entries, options);
  return legend;
}

}  // namespace meshloop::show
