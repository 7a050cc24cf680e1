#pragma once
#include <CLI/CLI.hpp>
#include <vector>

#include "common/base/result.h"
#include "device/draw/ar_renderer.h"

namespace meshloop {

/// `--object-at X,Y,Z --object-up X,Y,Z --object-height M`: the virtual object.
struct ObjectArguments {
  std::vector<double> position{0, 0, 0};
  std::vector<double> up{0, 0, 1};
  double height_m = 0.18;

  void add_to(CLI::App& command);
  /// Refuses an up direction of no length.
  [[nodiscard]] Result<VirtualObject> make() const;
};

}  // namespace meshloop
