#include "server/pipeline/pose_trust.h"

#include <fmt/format.h>

namespace meshloop {

void PoseTrust::lose() {
  constexpr int kGoodFramesAfterBad = 5;
  frames_due_ = kGoodFramesAfterBad;
  was_lost_ = true;
}

std::optional<std::string> PoseTrust::regain() {
  auto why = doubt();
  if (why) --frames_due_;
  return why;
}

std::optional<std::string> PoseTrust::doubt() const {
  if (frames_due_ == 0) return std::nullopt;
  return fmt::format("{}: {} more frame{} must speak for them",
                     was_lost_ ? "the poses were wrong a moment ago" : "the poses are not known to be right yet",
                     frames_due_, frames_due_ == 1 ? "" : "s");
}

std::string PoseTrust::why_nothing_is_proposed() const {
  const auto why = doubt();
  return "nothing is proposed now" + (why ? "; " + *why : "");
}

}  // namespace meshloop
