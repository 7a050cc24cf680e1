#pragma once
// The views of a comparison as the subcommands draw them: options of the command line, and the drawing.
#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <map>
#include <string>
#include <vector>

#include "server/pipeline/examiner.h"
#include "server/show/overlay.h"
#include "server/show/thumbnail.h"

namespace meshloop {

/// `[--palette paper|safe] [--opacity N] [--views color|depth|both|none]`
struct ViewArguments {
  std::string palette = "paper";
  OverlayOptions overlay;
  std::string views = "color";

  /// --palette and --opacity.
  void add_colors_to(CLI::App& command);
  /// --views too, for a command that writes the pictures as files.
  void add_to(CLI::App& command);
  /// The options with a title.
  [[nodiscard]] OverlayOptions options(const std::string& title) const;
};

/// What is framed in place of an examination's regions.
struct Framing {
  RegionMap regions;
  /// Beside their frames, in place of their numbers.
  std::map<RegionId, std::string> region_texts;
  /// Framed as the colour camera sees them, whether anything differs there or not; in the world.
  struct Place {
    Eigen::AlignedBox3d box_m;
    std::string text;
  };
  std::vector<Place> places;
};

/// Draws the views of one examined frame. One thread, that of the context.
class Views {
 public:
  [[nodiscard]] static Result<Views> create(GpuContext& gpu, const Rig& rig, const ViewArguments& arguments);
  /// Which views are written.
  [[nodiscard]] bool wants_color() const { return arguments_.views == "color" || arguments_.views == "both"; }
  [[nodiscard]] bool wants_depth() const { return arguments_.views == "depth" || arguments_.views == "both"; }
  /// `framing`: in place of the examination's regions.
  [[nodiscard]] Result<ColorImage> on_color(const TrackedFrame& tracked, const Examination& examination,
                                            const std::string& title, const Framing* framing = nullptr);
  [[nodiscard]] ColorImage on_depth(const TrackedFrame& tracked, const Examination& examination,
                                    const std::string& title) const;

  /// Small pictures of those of the wanted regions that the colour camera sees.
  [[nodiscard]] Result<std::vector<RegionThumbnail>> thumbnails(const TrackedFrame& tracked,
                                                                const Examination& examination,
                                                                const std::vector<RegionId>& wanted);

 private:
  Views(ColorOverlay color, Rig rig, ViewArguments arguments);

  [[nodiscard]] OverlayOptions options_of(const Examination& examination, const std::string& title) const;
  /// The rig moves between the two exposures.
  [[nodiscard]] Rig rig_at(const TrackedFrame& tracked) const;

  ColorOverlay color_;
  Rig rig_;
  ViewArguments arguments_;
};

}  // namespace meshloop
