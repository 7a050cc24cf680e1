#include "server/pipeline/change_tally.h"

#include <fmt/format.h>

#include <algorithm>

namespace meshloop {
namespace {

std::string frames_text(int count) {
  return fmt::format("{} frame{}", count, count == 1 ? "" : "s");
}

}  // namespace

void ChangeTally::add_withheld(int frame, const PoseObjection& objection) {
  Closed& closed = closed_[static_cast<std::size_t>(objection.gate)];
  if (closed.frames == 0) {
    closed.first_frame = frame;
    closed.first_reason = objection.reason;
  }
  ++closed.frames;
}

int ChangeTally::objected() const {
  int frames = 0;
  for (const auto& closed : closed_) frames += closed.frames;
  return frames;
}

const ChangeTally::Closed* ChangeTally::main_gate() const {
  const auto main = std::max_element(closed_.begin(), closed_.end(),
                                     [](const Closed& a, const Closed& b) { return a.frames < b.frames; });
  return main->frames > 0 ? &*main : nullptr;
}

nlohmann::json ChangeTally::json() const {
  const auto* main = main_gate();
  return {{"confirmed", confirmed_},
          {"waiting", waiting_},
          {"looked_at", usable_ + withheld()},
          {"withheld", withheld()},
          {"reason", main != nullptr ? nlohmann::json(main->first_reason) : nlohmann::json(nullptr)}};
}

std::string ChangeTally::why_withheld() const {
  const auto* main = main_gate();
  if (main == nullptr) return {};
  return fmt::format("{} with confirmed changes {} withheld, {} of them for what is wrong in frame {}: {}",
                     frames_text(withheld()), withheld() == 1 ? "was" : "were", main->frames, main->first_frame,
                     main->first_reason);
}

}  // namespace meshloop
