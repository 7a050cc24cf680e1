#include "device/draw/hud.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

namespace meshloop {
namespace {

constexpr int kMargin_px = 6;
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kBackgroundShare = 0.35;
/// Height of the picture for which the letters have scale 1.
constexpr double kHeightOfUnitScale_px = 1100;

}  // namespace

std::string hud_text(const HudState& state) {
  std::vector<std::string> parts;
  if (state.revision > 0) parts.push_back(fmt::format("revision {}", state.revision));
  if (!state.tracking.empty()) parts.push_back(state.tracking);
  if (state.frames_per_s > 0) parts.push_back(fmt::format("{:.0f} frames/s", state.frames_per_s));
  return fmt::format("{}", fmt::join(parts, " | "));
}

void draw_hud(ColorImage& picture, const HudState& state) {
  const std::string text = hud_text(state);
  if (picture.empty() || text.empty()) return;
  const double scale = std::max(0.38, picture.height() / kHeightOfUnitScale_px);
  int below_px = 0;
  const cv::Size letters = cv::getTextSize(text, kFont, scale, 1, &below_px);
  const cv::Rect strip{kMargin_px, picture.height() - letters.height - below_px - 3 * kMargin_px,
                       letters.width + 2 * kMargin_px, letters.height + below_px + 2 * kMargin_px};
  cv::Mat pixels{picture.height(), picture.width(), CV_8UC3, picture.data()};
  if ((strip & cv::Rect{0, 0, pixels.cols, pixels.rows}) != strip) return;
  pixels(strip) *= kBackgroundShare;
  const cv::Scalar color = state.tracking == "lost" ? cv::Scalar{255, 120, 90} : cv::Scalar{235, 240, 235};
  cv::putText(pixels, text, {strip.x + kMargin_px, strip.y + kMargin_px + letters.height}, kFont, scale, color, 1,
              cv::LINE_AA);
}

}  // namespace meshloop
