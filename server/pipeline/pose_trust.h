#pragma once
#include <optional>
#include <string>

namespace meshloop {

/// Whether the poses of the last frames allow the model to be changed. What made a pose wrong is hardly gone after one
/// frame that does not show it, so several must follow.
class PoseTrust {
 public:
  /// A frame whose pose was found wrong.
  void lose();
  /// A frame with something to propose that passed the gates. Returns why nothing is done with it, if so.
  [[nodiscard]] std::optional<std::string> regain();
  /// Why the model may not be changed now.
  [[nodiscard]] std::optional<std::string> doubt() const;
  /// Where nothing is proposed: that, and the doubt that may be why.
  [[nodiscard]] std::string why_nothing_is_proposed() const;

 private:
  int frames_due_ = 0;
};

}  // namespace meshloop
