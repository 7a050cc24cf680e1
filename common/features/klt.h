#pragma once
// Corners in one image and where they went in the next (Shi, Tomasi 1994; Bouguet 2000). Pure functions.
#include <Eigen/Core>
#include <vector>

#include "common/image/image.h"

namespace meshloop {

struct CornerOptions {
  int max_corners = 400;
  /// Of the strongest corner's response.
  double quality = 0.01;
  double min_distance_px = 10;
  /// Corners are spread over a grid of this many cells a side, so that one textured object does not take them all.
  int grid = 6;
};

/// Corners that keep min_distance to `taken` and to each other, where mask (when not empty) is not 0.
[[nodiscard]] std::vector<Eigen::Vector2d> find_corners(const GreyImage& image, const GreyImage& mask,
                                                        const std::vector<Eigen::Vector2d>& taken,
                                                        const CornerOptions& options);

struct FlowOptions {
  int window_px = 21;
  int pyramid_levels = 4;
  /// A point tracked forward and back must return within this distance.
  double max_round_trip_px = 0.5;
};

/// The options for pictures of another width than the 640 pixels that the defaults are meant for. In smaller ones
/// lengths follow the root of the width: a corner still needs its surroundings to be told from others. In larger ones
/// only the pyramid grows, since wider windows reach over the edges of things.
[[nodiscard]] CornerOptions corner_options_for(int width);
[[nodiscard]] FlowOptions flow_options_for(int width);

struct TrackedPoint {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  bool found = false;
};

/// Where `points` of `from` are in `to`. `guesses` is empty or has one start per point. The images have equal size.
[[nodiscard]] std::vector<TrackedPoint> track_points(const GreyImage& from, const GreyImage& to,
                                                     const std::vector<Eigen::Vector2d>& points,
                                                     const std::vector<Eigen::Vector2d>& guesses,
                                                     const FlowOptions& options);

}  // namespace meshloop
