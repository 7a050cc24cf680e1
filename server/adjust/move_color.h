#pragma once
#include <optional>

#include "server/adjust/color_lookup.h"
#include "server/adjust/move_scene.h"

namespace meshloop::adjust {

/// What colours are compared.
struct PartColors {
  /// The part's texture, decoded; empty without one, and where it cannot be decoded.
  ColorImage picture;
  const ColorLookup& seen;
};
/// Decodes the texture. The lookup must outlive what comes back.
[[nodiscard]] PartColors colors_of(const Part& part, const ColorLookup& seen);

/// How well the colours of a part (its vertices', or its texture's where pixels show it) fit the picture's at a pose:
/// correlation of what is seen of them, from -1 to 1, each channel about its own mean. Nothing where either is too even
/// to tell.
[[nodiscard]] std::optional<double> color_agreement(const MoveScene& scene, const Part& part, const PartColors& colors,
                                                    const Pose& T_camera_node);

}  // namespace meshloop::adjust
