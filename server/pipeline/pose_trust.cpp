#include "server/pipeline/pose_trust.h"

#include <fmt/format.h>

namespace meshloop {

void PoseTrust::lose() {
  constexpr int kGoodFramesAfterBad = 5;
  frames_due_ = kGoodFramesAfterBad;
}

std::optional<std::string> PoseTrust::regain() {
  auto why = doubt();
  if (why) --frames_due_;
  return why;
}

std::optional<std::string> PoseTrust::doubt() const {
  if (frames_due_ == 0) return std::nullopt;
  return fmt::format("the poses were wrong a moment ago: {} more frame{} must speak for them", frames_due_,
                     frames_due_ == 1 ? "" : "s");
}

std::string PoseTrust::why_nothing_is_proposed() const {
  const auto why = doubt();
  return "nothing is proposed now" + (why ? "; " + *why : "");
}

}  // namespace meshloop
