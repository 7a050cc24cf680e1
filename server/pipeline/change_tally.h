#pragma once
// What became of a live run's frames with confirmed changes.
#include <array>
#include <string>

#include <nlohmann/json.hpp>

#include "server/pipeline/adjuster.h"

namespace meshloop {

/// Counts frames with confirmed changes. Of those that neither waited nor were like the one before, each is looked at:
/// it may change the model, or it is withheld.
class ChangeTally {
 public:
  void add_confirmed() { ++confirmed_; }
  /// A frame that may not change the model, for its motion or its uncertain pose.
  void add_waiting() { ++waiting_; }
  void add_usable() { ++usable_; }
  void add_withheld(int frame, const PoseObjection& objection);
  /// Good itself, but it follows one that was withheld.
  void add_distrusted() { ++distrusted_; }

  /// Frames with confirmed changes were looked at, none could be used, and most were wrong themselves.
  [[nodiscard]] bool is_all_withheld() const { return usable_ == 0 && objected() > distrusted_; }
  /// `confirmed`, `waiting`, `looked_at`, `withheld` (frames), and `reason`, of the gate that closed most often in the
  /// frame where it did first; null where none did.
  [[nodiscard]] nlohmann::json json() const;
  /// How many were withheld, and the main reason, which says what to check.
  [[nodiscard]] std::string why_withheld() const;

 private:
  struct Closed {
    int frames = 0;
    int first_frame = 0;
    std::string first_reason;
  };
  /// Frames that a gate closed for.
  [[nodiscard]] int objected() const;
  [[nodiscard]] int withheld() const { return objected() + distrusted_; }
  /// Of a tie the gate that comes first; nothing where none closed.
  [[nodiscard]] const Closed* main_gate() const;

  int confirmed_ = 0;
  int waiting_ = 0;
  int usable_ = 0;
  int distrusted_ = 0;
  std::array<Closed, kPoseGates> closed_;
};

}  // namespace meshloop
