#include "device/draw/lathe.h"

#include <cmath>
#include <numbers>

namespace meshloop {
namespace {

constexpr float kTurn = 2 * std::numbers::pi_v<float>;

void add_rings(Submesh& mesh, const Profile& profile, const Sweep& sweep, const LatheColor& color,
               const LatheRadius& radius_scale) {
  for (int step = 0; step <= sweep.steps; ++step) {
    const float share = static_cast<float>(step) / static_cast<float>(sweep.steps);
    const float angle = sweep.from + (sweep.to - sweep.from) * share;
    for (std::size_t i = 0; i < profile.size(); ++i) {
      const float radius = profile[i].x() * (radius_scale ? radius_scale(angle, i) : 1.0f);
      mesh.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), profile[i].y());
      mesh.colors.push_back(color(angle, i));
    }
  }
}

}  // namespace

Sweep full_turn(int steps) {
  return {0, kTurn, steps};
}

void add_lathe(Submesh& mesh, const Profile& profile, const Sweep& sweep, const LatheColor& color,
               const LatheRadius& radius_scale) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const auto rings = static_cast<std::uint32_t>(profile.size());
  const auto steps = static_cast<std::uint32_t>(sweep.steps);
  add_rings(mesh, profile, sweep, color, radius_scale);
  // A full turn ends in the vertices it began with, so that the normals know no seam.
  const bool closed = std::abs(sweep.to - sweep.from - kTurn) < 1e-5f;
  if (closed) {
    mesh.positions.resize(mesh.positions.size() - rings);
    mesh.colors.resize(mesh.colors.size() - rings);
  }
  const auto vertex = [&](std::uint32_t step, std::uint32_t i) {
    return first + (closed ? step % steps : step) * rings + i;
  };
  for (std::uint32_t step = 0; step < steps; ++step) {
    for (std::uint32_t i = 0; i + 1 < rings; ++i) {
      if (profile[i + 1].x() + profile[i].x() <= 0) continue;
      const auto a = vertex(step, i);
      const auto b = vertex(step + 1, i);
      const auto c = vertex(step + 1, i + 1);
      const auto d = vertex(step, i + 1);
      if (profile[i].x() > 0) mesh.triangles.push_back({a, b, c});
      if (profile[i + 1].x() > 0) mesh.triangles.push_back({a, c, d});
    }
  }
}

Profile tube_profile(float ring, float z, float thickness, int steps) {
  Profile profile;
  for (int i = 0; i <= steps; ++i) {
    const float angle = kTurn * static_cast<float>(i) / static_cast<float>(steps) - kTurn / 2;
    profile.emplace_back(ring + thickness * std::cos(angle), z + thickness * std::sin(angle));
  }
  return profile;
}

}  // namespace meshloop
