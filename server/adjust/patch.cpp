#include "server/adjust/patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <span>
#include <utility>

#include "common/base/median.h"
#include "common/mesh/lattice.h"
#include "server/adjust/decimate.h"
#include "server/adjust/depth_grid.h"
#include "server/adjust/flat_parts.h"
#include "server/adjust/grid_mesh.h"
#include "server/adjust/patch_points.h"
#include "server/adjust/patch_texture.h"
#include "server/adjust/stitch.h"
#include "server/adjust/straight_lines.h"

namespace meshloop::adjust {
namespace {

constexpr Rgb8 kGrey{128, 128, 128};

// Smoothing a sensor that is nearly free of noise would only round its edges.
bool worth_smoothing(const SensorModel& sensor) {
  return sensor.kind() != SensorModel::Kind::constant || sensor.constant_m() >= 0.0015;
}

/// Where a vertex takes its colour from: what was put onto the border's straight lines lies half a pixel or more beyond
/// what was measured, and the picture may show the background there.
VertexPlaces colored_places(VertexPlaces moved) {
  for (std::size_t i = 0; i < moved.places.size(); ++i) {
    if (moved.lines[i] == 0) moved.places[i].z() = 0;
  }
  return moved;
}

template <class Visit>
void for_vertices_around(const DepthGrid& grid, const GridVertices& vertices, std::uint32_t pixel, const Visit& visit) {
  const int w = grid.window.width();
  const int x = static_cast<int>(pixel) % w;
  const int y = static_cast<int>(pixel) / w;
  for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, grid.window.height() - 1); ++ny) {
    for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, w - 1); ++nx) {
      const auto i = static_cast<std::uint32_t>(ny * w + nx);
      if (vertices.is_vertex[i] != 0) visit(i, vertices.number_of_pixel[i]);
    }
  }
}

/// Coloured vertices beside one that is not.
std::vector<std::uint32_t> colored_beside_others(const DepthGrid& grid, const GridVertices& vertices,
                                                 const ColorsOfPoints& found) {
  std::vector<std::uint32_t> pixels;
  for (std::size_t n = 0; n < found.seen.size(); ++n) {
    if (found.seen[n] != 0) continue;
    for_vertices_around(grid, vertices, vertices.pixels[n], [&](std::uint32_t pixel, std::uint32_t number) {
      if (found.seen[number] != 0) pixels.push_back(pixel);
    });
  }
  std::sort(pixels.begin(), pixels.end());
  pixels.erase(std::unique(pixels.begin(), pixels.end()), pixels.end());
  return pixels;
}

// Breadth first over the pixel grid, from all coloured vertices at once: each other one takes the nearest one's colour.
void spread_colors(const DepthGrid& grid, const GridVertices& vertices, ColorsOfPoints& found) {
  auto queue = colored_beside_others(grid, vertices, found);
  for (std::size_t head = 0; head < queue.size(); ++head) {
    const Rgb8 color = found.colors[vertices.number_of_pixel[queue[head]]];
    for_vertices_around(grid, vertices, queue[head], [&](std::uint32_t pixel, std::uint32_t number) {
      if (found.seen[number] != 0) return;
      found.seen[number] = 1;
      found.colors[number] = color;
      queue.push_back(pixel);
    });
  }
  for (std::size_t n = 0; n < found.colors.size(); ++n) {
    if (found.seen[n] == 0) found.colors[n] = kGrey;
  }
}

std::vector<Rgb8> color_vertices(const DepthGrid& grid, const GridVertices& vertices,
                                 const std::vector<Eigen::Vector3f>& points, const ColorLookup& lookup) {
  std::vector<float> sigmas(points.size());
  std::transform(vertices.pixels.begin(), vertices.pixels.end(), sigmas.begin(),
                 [&](std::uint32_t pixel) { return grid.sigma[pixel]; });
  auto found = lookup.colors_of(points, sigmas);
  for (std::size_t n = 0; n < points.size(); ++n) {
    // What was not measured may not be what the colour camera sees there.
    if (grid.role[vertices.pixels[n]] == Role::gap) found.seen[n] = 0;
  }
  const bool all = std::find(found.seen.begin(), found.seen.end(), std::uint8_t{0}) == found.seen.end();
  if (!all) spread_colors(grid, vertices, found);
  return std::move(found.colors);
}

/// Of a patch's vertices: of some thousand of them, which is what a median needs. There must be some.
float median_over(const GridVertices& vertices, const std::vector<float>& values) {
  constexpr std::size_t kEnough = 4096;
  const std::size_t step = vertices.pixels.size() / kEnough + 1;
  std::vector<float> some;
  some.reserve(kEnough);
  for (std::size_t n = 0; n < vertices.pixels.size(); n += step) some.push_back(values[vertices.pixels[n]]);
  return median(std::move(some));
}

/// Of the measurements behind a patch's vertices; there must be some.
float sigma_of(const DepthGrid& grid, const GridVertices& vertices) {
  return median_over(vertices, grid.sigma);
}

// Rounding adds spacing / sqrt(12) of noise (uniform distribution): at most a fifth of the sensor's own. And where the
// lattice is not clearly finer than the pixels, triangles fold over: with a spacing of 0.75 of a pixel's width 0.3 % of
// a Kinect's lose their area, with 1.2 times it 13 %.
int coarsening(const DepthGrid& grid, const GridVertices& vertices, const Camera& camera) {
  constexpr float kShareOfPixel = 0.75f;
  const float pixel_m = median_over(vertices, grid.z) / static_cast<float>(std::max(camera.fx, camera.fy));
  const float largest_m = std::min(sigma_of(grid, vertices) * std::sqrt(12.0f) / 5, kShareOfPixel * pixel_m);
  if (4 * kLatticeSpacing_m <= largest_m) return 4;
  return 2 * kLatticeSpacing_m <= largest_m ? 2 : 1;
}

/// The patch's vertices that are the model's too.
std::vector<std::uint32_t> join_to_model(Submesh& patch, const Snapshot& snapshot, const GridMesh& mesh,
                                         const GridVertices& vertices, float sigma_m) {
  if (snapshot.model->nodes.empty()) return {};
  auto border = border_of(mesh);
  for (auto& [from, to] : border) {
    from = vertices.number_of_pixel[from];
    to = vertices.number_of_pixel[to];
  }
  const StitchView view{&snapshot.rig->depth, snapshot.depth_pose.T_camera_world.cast<float>(), sigma_m};
  return stitch(patch, std::move(border), *snapshot.model, view);
}

using Place = std::array<float, 3>;

Place place_of(const Eigen::Vector3f& p) {
  return {p.x(), p.y(), p.z()};
}

std::set<Place> places_of(const Submesh& patch, const std::vector<std::uint32_t>& vertices) {
  std::set<Place> places;
  for (const auto i : vertices) places.insert(place_of(patch.positions[i]));
  return places;
}

std::vector<std::uint32_t> vertices_at(const Submesh& patch, const std::set<Place>& places) {
  std::vector<std::uint32_t> found;
  for (std::uint32_t i = 0; i < patch.positions.size(); ++i) {
    if (places.contains(place_of(patch.positions[i]))) found.push_back(i);
  }
  return found;
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
  GridMesh mesh = join_pixels(grid, rig.depth, options.discontinuity_sigmas, places.lines);
  drop_small_pieces(mesh, least_triangles(options, rig.depth));
  const GridVertices vertices = number_vertices(mesh);
  if (vertices.pixels.empty()) return {};
  if (!parts.planes.empty()) straighten_border(grid, parts, mesh, vertices, places);

  Submesh patch;
  const auto points = back_project(grid, places, rig.depth, vertices);
  // The model's own depth belongs to the pose that it was drawn with.
  const Pose& T_depth_world = snapshot.depth_pose.T_camera_world;
  const Eigen::Isometry3f T_world_model = T_depth_world.inverse().cast<float>();
  const Pose placed_T_depth_world = snapshot.refined_T_camera_world.value_or(T_depth_world);
  const Eigen::Isometry3f T_world_depth = placed_T_depth_world.inverse().cast<float>();
  if (options.texture) {
    patch.texture = make_patch_texture(grid, vertices.pixels, {rig.depth, placed_T_depth_world}, colors);
  }
  if (!patch.texture) {
    patch.colors =
        places.places.empty()
            ? color_vertices(grid, vertices, points, colors)
            : color_vertices(grid, vertices, back_project(grid, colored_places(places), rig.depth, vertices), colors);
  }
  patch.positions = transformed(T_world_depth, points);
  for (std::size_t n = 0; n < points.size(); ++n) {
    if (grid.role[vertices.pixels[n]] == Role::model_rim) patch.positions[n] = T_world_model * points[n];
  }
  patch.triangles = triangles_of(mesh, vertices);
  std::vector<std::uint32_t> joined;
  if (options.stitch) joined = join_to_model(patch, snapshot, mesh, vertices, sigma_of(grid, vertices));
  if (options.decimate_sigmas > 0) {
    const auto shared = places_of(patch, joined);
    patch = decimate(patch, options.decimate_sigmas * sigma_of(grid, vertices), options.decimate_levels,
                     joined.empty() ? Border::decimated : Border::kept);
    joined = vertices_at(patch, shared);
  }
  // What lies on a plane is not as noisy as the sensor.
  const int coarse = parts.planes.empty() ? coarsening(grid, vertices, rig.depth) : 1;
  return snap_to_lattice(std::move(patch), coarse, joined);
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
  auto others = split(keep_triangles(std::move(submesh), first), max_triangles);
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
