// The ray casting behind cast_depth and cast_color.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "common/simulation/light.h"
#include "common/simulation/parallel.h"
#include "common/simulation/sensor.h"
#include "common/simulation/solid_shape.h"
#include "common/simulation/view_cast.h"

namespace meshloop::simulation {
namespace {

// Colours of neighbours that differ by more than this (grey levels, any channel) are worth more rays.
constexpr int kVisibleStep = 10;

int threads_for(int asked) {
  return asked > 0 ? asked : processor_count();
}

// Calls work(tile column, tile row, u, v) for all pixels of a picture.
template <class Work>
void for_each_pixel(const ViewCast& view, const Camera& camera, int threads, const Work& work) {
  for_each_parallel(view.tile_rows(), threads, [&](int tile_row) {
    const int v_end = std::min(camera.height, (tile_row + 1) * ViewCast::kTile);
    for (int v = tile_row * ViewCast::kTile; v < v_end; ++v) {
      for (int u = 0; u < camera.width; ++u) work(u / ViewCast::kTile, tile_row, u, v);
    }
  });
}

/// What a ray meets; equal for rays that meet the same face in the same light.
struct Surface {
  std::int16_t solid = -1;
  std::int8_t face = 0;
  bool lit = false;
  [[nodiscard]] bool is_background() const { return solid < 0; }
  [[nodiscard]] bool is_flat() const { return solid >= 0 && face != kMantle; }
  friend bool operator==(const Surface&, const Surface&) = default;
};

struct Sample {
  Rgb8 color;
  Surface surface;
};

/// How a pixel deserves more rays: where its neighbours lie on other surfaces, these have to be found again; inside a
/// flat face only the print on it changes.
enum class Refinement { none, print, rays };

std::uint8_t shade(std::uint8_t channel, int brightness) {
  return static_cast<std::uint8_t>(std::min(255, (channel * brightness + 128) >> 8));
}

/// How the lamps light a surface: brightness in 1/256, in the lamp's shadow and out of it.
struct Lighting {
  Lighting(const Light& light, const Eigen::Vector3d& normal_world)
      : dark{rounded(light.brightness(normal_world, false))},
        bright{rounded(light.brightness(normal_world, true))},
        turned_to_lamp{light.is_turned_to_lamp(normal_world)} {}

  static int rounded(double brightness) { return static_cast<int>(brightness * 256 + 0.5); }

  int dark;
  int bright;
  bool turned_to_lamp;
};

/// The colours along the rays of one view.
class ColorCast {
 public:
  ColorCast(const Scene& scene, const Camera& camera, const Pose& T_camera_world)
      : scene_{scene},
        view_{scene, camera, T_camera_world, false},
        light_{scene},
        R_world_camera_{T_camera_world.linear().transpose()} {
    for (const Solid& solid : scene.solids) {
      for (int face = 0; face < kMantle; ++face) {
        const Eigen::Vector3d normal = normal_of_face(face, Eigen::Vector3d::Zero());
        flat_faces_.emplace_back(light_, solid.T_world_solid.linear() * normal);
      }
    }
  }

  [[nodiscard]] const ViewCast& view() const { return view_; }

  [[nodiscard]] Sample sample(int tile_column, int tile_row, double u, double v) const {
    const Hit hit = view_.cast(tile_column, tile_row, u, v);
    if (hit.solid < 0) return {scene_.background(R_world_camera_ * view_.ray(u, v)), {}};
    const Solid& solid = scene_.solids[static_cast<std::size_t>(hit.solid)];
    const Eigen::Vector3d normal_solid = normal_of_face(hit.face, hit.p_solid);
    const Lighting lighting = hit.face == kMantle ? Lighting(light_, solid.T_world_solid.linear() * normal_solid)
                                                  : lighting_of(hit.solid, hit.face);
    const bool lit = lighting.turned_to_lamp && light_.reaches(solid.T_world_solid * hit.p_solid, hit.solid);
    const Rgb8 color = shaded(solid.texture(hit.p_solid, normal_solid), lighting, lit);
    return {color, {static_cast<std::int16_t>(hit.solid), static_cast<std::int8_t>(hit.face), lit}};
  }

  /// The colour of a flat face that is known to lie behind (u, v).
  [[nodiscard]] Rgb8 print(const Surface& surface, double u, double v) const {
    const Eigen::Vector3d p_solid = view_.on_flat_face(surface.solid, surface.face, u, v);
    const Texture& texture = scene_.solids[static_cast<std::size_t>(surface.solid)].texture;
    const Rgb8 paint = texture(p_solid, normal_of_face(surface.face, p_solid));
    return shaded(paint, lighting_of(surface.solid, surface.face), surface.lit);
  }

 private:
  [[nodiscard]] const Lighting& lighting_of(int solid, int face) const {
    return flat_faces_[static_cast<std::size_t>(solid * kMantle + face)];
  }
  static Rgb8 shaded(Rgb8 paint, const Lighting& lighting, bool lit) {
    const int brightness = lit ? lighting.bright : lighting.dark;
    return {shade(paint.r, brightness), shade(paint.g, brightness), shade(paint.b, brightness)};
  }

  const Scene& scene_;
  ViewCast view_;
  Light light_;
  Eigen::Matrix3d R_world_camera_;
  /// Six for each solid, whatever its shape.
  std::vector<Lighting> flat_faces_;
};

// The mean of color_at(u, v) over n x n places in a pixel.
template <class ColorAt>
Rgb8 mean_over_pixel(int u, int v, int n, const ColorAt& color_at) {
  std::array<int, 3> sum{};
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const Rgb8 color = color_at(u + (i + 0.5) / n - 0.5, v + (j + 0.5) / n - 0.5);
      sum[0] += color.r;
      sum[1] += color.g;
      sum[2] += color.b;
    }
  }
  const auto rounded = [count = n * n](int total) { return static_cast<std::uint8_t>((total + count / 2) / count); };
  return {rounded(sum[0]), rounded(sum[1]), rounded(sum[2])};
}

bool differ_visibly(Rgb8 a, Rgb8 b) {
  return std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)}) > kVisibleStep;
}

Refinement refinement_of(const Image<Sample>& samples, int u, int v) {
  constexpr std::array<std::array<int, 2>, 4> kNeighbours{{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
  const Sample& centre = samples(u, v);
  bool print_changes = false;
  bool at_border = false;
  for (const auto& [du, dv] : kNeighbours) {
    if (u + du < 0 || v + dv < 0 || u + du >= samples.width() || v + dv >= samples.height()) {
      at_border = true;
      continue;
    }
    const Sample& neighbour = samples(u + du, v + dv);
    if (neighbour.surface != centre.surface) return Refinement::rays;
    print_changes = print_changes || differ_visibly(neighbour.color, centre.color);
  }
  // The room is soft already: a pixel sees about one texel of it.
  if (!print_changes || centre.surface.is_background()) return Refinement::none;
  // A face is convex: it lies behind all that is between four neighbours on it.
  return centre.surface.is_flat() && !at_border ? Refinement::print : Refinement::rays;
}

}  // namespace

ExactDepth cast_depth(const Scene& scene, const Camera& camera, const Pose& T_camera_world, bool modelled_only,
                      int threads) {
  ExactDepth exact{DepthImage{camera.width, camera.height}, Image<std::uint16_t>{camera.width, camera.height},
                   Image<float>{camera.width, camera.height}};
  const ViewCast view(scene, camera, T_camera_world, modelled_only);
  std::vector<Eigen::Matrix3d> R_camera_solid;
  for (const Solid& solid : scene.solids) {
    R_camera_solid.emplace_back(T_camera_world.linear() * solid.T_world_solid.linear());
  }
  for_each_pixel(view, camera, threads_for(threads), [&](int tile_column, int tile_row, int u, int v) {
    const Hit hit = view.cast(tile_column, tile_row, u, v);
    if (hit.solid < 0) return;
    const Eigen::Vector3d normal =
        R_camera_solid[static_cast<std::size_t>(hit.solid)] * normal_of_face(hit.face, hit.p_solid);
    const Eigen::Vector3d ray = view.ray(u, v);
    exact.depth(u, v) = static_cast<float>(hit.depth_m);
    exact.solid(u, v) = static_cast<std::uint16_t>(hit.solid + 1);
    exact.cos_theta(u, v) = static_cast<float>(std::abs(normal.dot(ray)) / ray.norm());
  });
  return exact;
}

ColorImage cast_color(const Scene& scene, const Camera& camera, const Pose& T_camera_world, int supersampling,
                      int threads) {
  const ColorCast cast(scene, camera, T_camera_world);
  Image<Sample> samples(camera.width, camera.height);
  for_each_pixel(cast.view(), camera, threads_for(threads), [&](int tile_column, int tile_row, int u, int v) {
    samples(u, v) = cast.sample(tile_column, tile_row, u, v);
  });
  ColorImage image(camera.width, camera.height);
  for_each_pixel(cast.view(), camera, threads_for(threads), [&](int tile_column, int tile_row, int u, int v) {
    const Sample& centre = samples(u, v);
    const Refinement refinement = supersampling > 1 ? refinement_of(samples, u, v) : Refinement::none;
    if (refinement == Refinement::none) {
      image(u, v) = centre.color;
    } else if (refinement == Refinement::print) {
      image(u, v) =
          mean_over_pixel(u, v, supersampling, [&](double x, double y) { return cast.print(centre.surface, x, y); });
    } else {
      image(u, v) = mean_over_pixel(u, v, supersampling,
                                    [&](double x, double y) { return cast.sample(tile_column, tile_row, x, y).color; });
    }
  });
  return image;
}

}  // namespace meshloop::simulation
