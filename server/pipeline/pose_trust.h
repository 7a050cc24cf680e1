#pragma once
#include <optional>
#include <string>

namespace meshloop {

/// Whether the poses of the last frames allow the model to be changed. What makes a pose wrong does not show in every
/// frame: so several must speak for the poses before the first change, and more of them after one that was wrong.
class PoseTrust {
 public:
  /// A frame whose pose was found wrong.
  void lose();
  /// A pose was found wrong.
  [[nodiscard]] bool was_lost() const { return was_lost_; }
  /// A frame with something to propose that passed the gates. Returns why nothing is done with it, if so.
  [[nodiscard]] std::optional<std::string> regain();
  /// Why the model may not be changed now.
  [[nodiscard]] std::optional<std::string> doubt() const;
  /// Where nothing is proposed: that, and the doubt that may be why.
  [[nodiscard]] std::string why_nothing_is_proposed() const;

 private:
  bool was_lost_ = false;
  int frames_due_ = 2;
};

}  // namespace meshloop
