#pragma once
#include <string>

#include "common/recording/recording.h"

namespace meshloop {

/// A rig with two different cameras and numbers that need all their digits.
inline Rig small_rig() {
  Rig rig;
  rig.color = {64, 48, 50.1, 50.123456789012345, 31.5, 23.5, {0.1, -0.02, 1.0 / 3, 0, 1e-17}};
  rig.depth = {32, 24, 30, 30.25, 15.5, 11.5, {}};
  rig.depth_scale = 0.000124986647;
  rig.T_depth_color = exp((Twist{} << -0.025, 0.001, -0.004, 0.01, -0.02, 0.03).finished());
  return rig;
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

}  // namespace meshloop
