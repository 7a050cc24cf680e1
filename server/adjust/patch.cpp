#include "server/adjust/patch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "common/mesh/lattice.h"
#include "server/adjust/decimate.h"
#include "server/adjust/depth_grid.h"
#include "server/adjust/flat_parts.h"
#include "server/adjust/straight_lines.h"

namespace meshloop::adjust {
namespace {

constexpr Rgb8 kGrey{128, 128, 128};
constexpr auto kUnused = std::numeric_limits<std::uint32_t>::max();

// Smoothing a sensor that is nearly free of noise would only round its edges.
bool worth_smoothing(const SensorModel& sensor) {
  return sensor.kind() != SensorModel::Kind::constant || sensor.constant_m() >= 0.0015;
}

/// The used pixels of a grid, numbered.
struct Vertices {
  std::vector<std::uint32_t> pixels;
  /// kUnused where a pixel is no vertex.
  std::vector<std::uint32_t> number_of_pixel;
};

Vertices number_vertices(const std::vector<Triangle>& triangles, std::size_t pixel_count) {
  Vertices vertices;
  vertices.number_of_pixel.assign(pixel_count, kUnused);
  for (const auto& triangle : triangles) {
    for (const auto i : triangle) vertices.number_of_pixel[i] = 0;
  }
  for (std::size_t i = 0; i < pixel_count; ++i) {
    if (vertices.number_of_pixel[i] == kUnused) continue;
    vertices.number_of_pixel[i] = static_cast<std::uint32_t>(vertices.pixels.size());
    vertices.pixels.push_back(static_cast<std::uint32_t>(i));
  }
  return vertices;
}

/// Where a vertex takes its colour from: what was put onto the border's straight lines lies half a pixel or more beyond
/// what was measured, and the picture may show the background there.
VertexPlaces colored_places(VertexPlaces moved) {
  for (std::size_t i = 0; i < moved.places.size(); ++i) {
    if (moved.lines[i] == 0) moved.places[i].z() = 0;
  }
  return moved;
}

std::vector<Eigen::Vector3f> back_project(const DepthGrid& grid, const VertexPlaces& moved, const Camera& camera,
                                          const Vertices& vertices) {
  std::vector<Eigen::Vector3f> points;
  points.reserve(vertices.pixels.size());
  const auto corner_u = static_cast<float>(grid.window.x0 - camera.cx);
  const auto corner_v = static_cast<float>(grid.window.y0 - camera.cy);
  const auto w = static_cast<std::uint32_t>(grid.window.width());
  for (const auto i : vertices.pixels) {
    Eigen::Vector3f p{static_cast<float>(i % w), static_cast<float>(i / w), grid.z[i]};
    if (!moved.places.empty() && moved.places[i].z() > 0) p = moved.places[i];
    const float u = p.x() + corner_u;
    const float v = p.y() + corner_v;
    points.emplace_back(u * p.z() / static_cast<float>(camera.fx), v * p.z() / static_cast<float>(camera.fy), p.z());
  }
  return points;
}

// Breadth first over the pixel grid, from all coloured vertices at once: each other one takes the nearest one's colour.
void spread_colors(const DepthGrid& grid, const Vertices& vertices, std::vector<bool>& colored,
                   std::vector<Rgb8>& colors) {
  const int w = grid.window.width();
  std::vector<std::uint32_t> queue;
  queue.reserve(vertices.pixels.size());
  for (std::size_t n = 0; n < colors.size(); ++n) {
    if (colored[n]) queue.push_back(vertices.pixels[n]);
  }
  for (std::size_t head = 0; head < queue.size(); ++head) {
    const auto from = vertices.number_of_pixel[queue[head]];
    const int x = static_cast<int>(queue[head]) % w;
    const int y = static_cast<int>(queue[head]) / w;
    for (int k = 0; k < 9; ++k) {
      const int nx = x + k % 3 - 1;
      const int ny = y + k / 3 - 1;
      if (nx < 0 || ny < 0 || nx >= w || ny >= grid.window.height()) continue;
      const auto pixel = static_cast<std::uint32_t>(ny * w + nx);
      const auto to = vertices.number_of_pixel[pixel];
      if (to == kUnused || colored[to]) continue;
      colored[to] = true;
      colors[to] = colors[from];
      queue.push_back(pixel);
    }
  }
}

std::vector<Rgb8> color_vertices(const DepthGrid& grid, const Vertices& vertices,
                                 const std::vector<Eigen::Vector3f>& points, const ColorLookup& lookup) {
  std::vector<Rgb8> colors(points.size(), kGrey);
  std::vector<bool> colored(points.size(), false);
  bool all = true;
  for (std::size_t n = 0; n < points.size(); ++n) {
    const auto pixel = vertices.pixels[n];
    // What was not measured may not be what the colour camera sees there.
    const auto color = grid.role[pixel] == Role::gap ? std::nullopt : lookup.color_of(points[n], grid.sigma[pixel]);
    colored[n] = color.has_value();
    if (color) colors[n] = *color;
    all = all && color;
  }
  if (!all) spread_colors(grid, vertices, colored, colors);
  return colors;
}

float median(std::vector<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Of the measurements behind a patch's vertices; there must be some.
float sigma_of(const DepthGrid& grid, const Vertices& vertices) {
  std::vector<float> sigmas;
  for (const auto pixel : vertices.pixels) sigmas.push_back(grid.sigma[pixel]);
  return median(std::move(sigmas));
}

// Rounding adds spacing / sqrt(12) of noise (uniform distribution): at most a fifth of the sensor's own. And where the
// lattice is not clearly finer than the pixels, triangles fold over: with a spacing of 0.75 of a pixel's width 0.3 % of
// a Kinect's lose their area, with 1.2 times it 13 %.
int coarsening(const DepthGrid& grid, const Vertices& vertices, const Camera& camera) {
  constexpr float kShareOfPixel = 0.75f;
  std::vector<float> depths;
  for (const auto pixel : vertices.pixels) depths.push_back(grid.z[pixel]);
  const float pixel_m = median(std::move(depths)) / static_cast<float>(std::max(camera.fx, camera.fy));
  const float largest_m = std::min(sigma_of(grid, vertices) * std::sqrt(12.0f) / 5, kShareOfPixel * pixel_m);
  if (4 * kLatticeSpacing_m <= largest_m) return 4;
  return 2 * kLatticeSpacing_m <= largest_m ? 2 : 1;
}

// Two triangles a pixel: what is small depends on how many pixels there are.
std::size_t least_triangles(const AdjustOptions& options, const Camera& camera) {
  const double scale = camera.width * static_cast<double>(camera.height) / (640.0 * 480.0);
  return static_cast<std::size_t>(std::lround(static_cast<double>(options.min_patch_triangles) * scale));
}

}  // namespace

Status validate(const Snapshot& snapshot) {
  if (!snapshot.model || !snapshot.frame || !snapshot.rig || !snapshot.comparison || !snapshot.regions) {
    return fail("the snapshot is not complete");
  }
  if (snapshot.depth_pose.state == TrackState::lost || !is_rigid(snapshot.depth_pose.T_camera_world)) {
    return fail("the depth camera's pose is lost; nothing is written to the model");
  }
  const Camera& camera = snapshot.rig->depth;
  const auto fits = [&](const auto& image) { return image.width() == camera.width && image.height() == camera.height; };
  const Comparison& c = *snapshot.comparison;
  if (!fits(snapshot.frame->depth) ||
      (snapshot.fused && (!fits(snapshot.fused->depth) || !fits(snapshot.fused->measurements))) || !fits(c.labels) ||
      !fits(c.expected) || !fits(c.node_index) || !fits(c.threshold_m) || !fits(snapshot.regions->ids)) {
    return fail("an image of the snapshot has another size than the rig's depth camera");
  }
  return validate(*snapshot.rig);
}

Submesh make_patch(const Snapshot& snapshot, RegionId region, const AdjustOptions& options, const ColorLookup& colors) {
  const Rig& rig = *snapshot.rig;
  const DepthImage& measured = snapshot.fused != nullptr ? snapshot.fused->depth : snapshot.frame->depth;
  const Image<std::uint8_t> one_each;
  const auto& measurements = snapshot.fused != nullptr ? snapshot.fused->measurements : one_each;
  DepthGrid grid =
      select_patch(*snapshot.comparison, measured, measurements, snapshot.regions->ids, region, rig.sensor);
  if (grid.window.empty()) return {};
  FlatParts parts;
  if (options.flatten) parts = find_flat_parts(grid);
  if (options.smooth && worth_smoothing(rig.sensor)) smooth(grid, measured);
  VertexPlaces places;
  if (!parts.planes.empty()) {
    fill_gaps(grid, parts, measured);
    snap_to_planes(grid, parts);
    places = meet_in_lines(grid, parts, *snapshot.comparison);
  }
  auto triangles = triangulate(grid, rig.depth, options.discontinuity_sigmas, places.lines);
  drop_small_pieces(triangles, grid.z.size(), least_triangles(options, rig.depth));
  if (triangles.empty()) return {};
  if (!parts.planes.empty()) straighten_border(grid, parts, triangles, places);

  Submesh patch;
  const Vertices vertices = number_vertices(triangles, grid.z.size());
  const auto points = back_project(grid, places, rig.depth, vertices);
  patch.colors =
      color_vertices(grid, vertices, back_project(grid, colored_places(places), rig.depth, vertices), colors);
  // The model's own depth belongs to the pose that it was drawn with.
  const Pose& T_depth_world = snapshot.depth_pose.T_camera_world;
  const Eigen::Isometry3f T_world_model = T_depth_world.inverse().cast<float>();
  const Eigen::Isometry3f T_world_depth =
      snapshot.refined_T_camera_world.value_or(T_depth_world).inverse().cast<float>();
  patch.positions.reserve(points.size());
  for (std::size_t n = 0; n < points.size(); ++n) {
    const bool is_model = grid.role[vertices.pixels[n]] == Role::model_rim;
    patch.positions.push_back((is_model ? T_world_model : T_world_depth) * points[n]);
  }
  for (auto& triangle : triangles) {
    for (auto& i : triangle) i = vertices.number_of_pixel[i];
  }
  patch.triangles = std::move(triangles);
  // What lies on a plane is not as noisy as the sensor.
  const int coarse = parts.planes.empty() ? coarsening(grid, vertices, rig.depth) : 1;
  if (options.decimate_sigmas > 0)
    patch = decimate(patch, options.decimate_sigmas * sigma_of(grid, vertices), options.decimate_levels);
  return snap_to_lattice(patch, coarse);
}

std::vector<Submesh> split(Submesh submesh, std::size_t max_triangles) {
  std::vector<Submesh> pieces;
  if (submesh.triangles.size() <= max_triangles || max_triangles == 0) {
    pieces.push_back(std::move(submesh));
    return pieces;
  }
  const auto center = [&](std::size_t t) {
    const auto& [a, b, c] = submesh.triangles[t];
    return Eigen::Vector3f(submesh.positions[a] + submesh.positions[b] + submesh.positions[c]);
  };
  Eigen::AlignedBox3f box;
  for (std::size_t t = 0; t < submesh.triangles.size(); ++t) box.extend(center(t));
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  std::vector<std::size_t> order(submesh.triangles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto middle = order.begin() + static_cast<std::ptrdiff_t>(order.size() / 2);
  std::nth_element(order.begin(), middle, order.end(),
                   [&](std::size_t a, std::size_t b) { return center(a)[axis] < center(b)[axis]; });
  std::vector<bool> first(order.size(), false);
  for (auto it = order.begin(); it != middle; ++it) first[*it] = true;
  pieces = split(keep_triangles(submesh, first), max_triangles);
  first.flip();
  auto others = split(keep_triangles(submesh, first), max_triangles);
  std::move(others.begin(), others.end(), std::back_inserter(pieces));
  return pieces;
}

}  // namespace meshloop::adjust

namespace meshloop {

Submesh insertion_patch(const Snapshot& snapshot, RegionId region, const AdjustOptions& options) {
  if (!adjust::validate(snapshot)) return {};
  return adjust::make_patch(snapshot, region, options, adjust::ColorLookup{snapshot});
}

}  // namespace meshloop
