#include "device/draw/demo_object.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "device/draw/lathe.h"

namespace meshloop {
namespace {

// All measures are shares of the height.
constexpr int kSteps = 48;
constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kTowerFoot = 0.105f;
constexpr float kTowerTop = 0.655f;
constexpr float kLanternTop = 0.80f;
constexpr Rgb8 kRed{196, 44, 38};
constexpr Rgb8 kWhite{238, 234, 224};
constexpr Rgb8 kIron{52, 56, 62};
constexpr Rgb8 kStone{176, 170, 158};
constexpr Rgb8 kLamp{255, 214, 112};
constexpr Rgb8 kGlass{92, 120, 138};
constexpr Rgb8 kWood{92, 58, 34};

LatheColor plain(Rgb8 color) {
  return [color](float, std::size_t) { return color; };
}

float tower_radius(float z) {
  const float up = (z - kTowerFoot) / (kTowerTop - kTowerFoot);
  return 0.098f + 0.055f * std::pow(std::clamp(1 - up, 0.0f, 1.0f), 1.4f);
}

void add_rock(Submesh& mesh) {
  const auto bumps = [](float angle, std::size_t i) {
    const float phase = static_cast<float>(i);
    return 1 + 0.07f * std::sin(3 * angle + 0.8f + phase) + 0.05f * std::sin(7 * angle + 2.1f * phase) +
           0.03f * std::sin(13 * angle + 1.3f + 3 * phase);
  };
  const auto shades = [](float angle, std::size_t i) {
    const float phase = static_cast<float>(i);
    const float light = 112 + 16 * std::sin(5 * angle + 2 * phase) + 10 * std::sin(11 * angle + 5 * phase);
    return Rgb8{static_cast<std::uint8_t>(light), static_cast<std::uint8_t>(light * 0.95f),
                static_cast<std::uint8_t>(light * 0.85f)};
  };
  add_lathe(mesh, {{0.275f, 0}, {0.28f, 0.02f}, {0.255f, 0.045f}, {0.235f, 0.06f}, {0.15f, 0.075f}, {0, 0.076f}},
            full_turn(kSteps), shades, bumps);
}

void add_tower(Submesh& mesh) {
  add_lathe(mesh, {{0.195f, 0.05f}, {0.195f, 0.095f}}, full_turn(kSteps), plain(kStone));
  add_lathe(mesh, {{0.195f, 0.095f}, {0.15f, kTowerFoot}}, full_turn(kSteps), plain(kStone));
  constexpr int kBands = 5;
  constexpr int kRingsOfBand = 4;
  for (int band = 0; band < kBands; ++band) {
    Profile profile;
    for (int ring = 0; ring <= kRingsOfBand; ++ring) {
      const float up = static_cast<float>(band * kRingsOfBand + ring) / (kBands * kRingsOfBand);
      const float z = kTowerFoot + up * (kTowerTop - kTowerFoot);
      profile.emplace_back(tower_radius(z), z);
    }
    add_lathe(mesh, profile, full_turn(kSteps), plain(band % 2 == 0 ? kWhite : kRed));
  }
}

/// A piece of wall that lies a little in front of the tower: a door, a window, and the frame around it.
void add_opening(Submesh& mesh, float angle, float bottom, float top, float half_width, Rgb8 color, float in_front) {
  Profile profile;
  for (int i = 0; i <= 6; ++i) {
    const float z = bottom + (top - bottom) * static_cast<float>(i) / 6;
    profile.emplace_back(tower_radius(z) + in_front, z);
  }
  add_lathe(mesh, profile, {angle - half_width, angle + half_width, 8}, plain(color));
}

void add_openings(Submesh& mesh) {
  constexpr float kFront = -kPi / 2;
  add_opening(mesh, kFront, kTowerFoot, 0.235f, 0.27f, kStone, 0.004f);
  add_opening(mesh, kFront, kTowerFoot, 0.222f, 0.21f, kWood, 0.008f);
  const std::array<Eigen::Vector2f, 4> windows{
      {{kFront + 0.2f, 0.36f}, {kFront - 0.25f, 0.52f}, {kFront + kPi, 0.30f}, {kFront + kPi + 0.3f, 0.46f}}};
  for (const auto& window : windows) {
    add_opening(mesh, window.x(), window.y(), window.y() + 0.062f, 0.21f, kStone, 0.004f);
    add_opening(mesh, window.x(), window.y() + 0.009f, window.y() + 0.053f, 0.15f, kGlass, 0.007f);
  }
}

void add_post(Submesh& mesh, float angle, float ring, float bottom, float top, float half_width) {
  const auto first = mesh.positions.size();
  add_lathe(mesh, {{half_width, bottom}, {half_width, top}}, full_turn(6), plain(kIron));
  const Eigen::Vector3f foot{ring * std::cos(angle), ring * std::sin(angle), 0};
  for (std::size_t i = first; i < mesh.positions.size(); ++i) mesh.positions[i] += foot;
}

void add_gallery(Submesh& mesh) {
  add_lathe(mesh, {{tower_radius(kTowerTop), 0.63f}, {0.145f, kTowerTop}}, full_turn(kSteps), plain(kStone));
  add_lathe(mesh, {{0.145f, kTowerTop}, {0.145f, 0.68f}}, full_turn(kSteps), plain(kIron));
  add_lathe(mesh, {{0.145f, 0.68f}, {0.07f, 0.68f}}, full_turn(kSteps), plain(kIron));
  for (const float z : {0.712f, 0.742f}) {
    add_lathe(mesh, tube_profile(0.136f, z, 0.0045f, 6), full_turn(kSteps), plain(kIron));
  }
  for (int i = 0; i < 12; ++i) {
    add_post(mesh, 2 * kPi * static_cast<float>(i) / 12, 0.136f, 0.68f, 0.744f, 0.0045f);
  }
}

void add_lantern(Submesh& mesh) {
  add_lathe(mesh, {{0.078f, 0.68f}, {0.078f, 0.705f}}, full_turn(kSteps), plain(kWhite));
  add_lathe(mesh, {{0.072f, 0.705f}, {0.072f, kLanternTop}}, full_turn(kSteps), plain(kLamp));
  for (int i = 0; i < 8; ++i) {
    add_post(mesh, 2 * kPi * (static_cast<float>(i) + 0.5f) / 8, 0.074f, 0.70f, kLanternTop, 0.005f);
  }
  add_lathe(mesh, {{0.07f, kLanternTop}, {0.104f, kLanternTop}}, full_turn(kSteps), plain(kIron));
  add_lathe(mesh, {{0.104f, kLanternTop}, {0.104f, 0.812f}}, full_turn(kSteps), plain(kIron));
  add_lathe(mesh, {{0.104f, 0.812f}, {0.085f, 0.84f}, {0.06f, 0.872f}, {0.034f, 0.898f}, {0.012f, 0.915f}},
            full_turn(kSteps), plain(kRed));
  Profile ball;
  for (int i = 0; i <= 8; ++i) {
    const float angle = kPi * static_cast<float>(i) / 8 - kPi / 2;
    ball.emplace_back(i % 8 == 0 ? 0.0f : 0.021f * std::cos(angle), 0.928f + 0.021f * std::sin(angle));
  }
  add_lathe(mesh, ball, full_turn(16), plain(kIron));
  add_lathe(mesh, {{0.006f, 0.945f}, {0.003f, 0.999f}, {0, 1}}, full_turn(8), plain(kIron));
}

}  // namespace

Submesh make_lighthouse(double height_m) {
  Submesh mesh;
  add_rock(mesh);
  add_tower(mesh);
  add_openings(mesh);
  add_gallery(mesh);
  add_lantern(mesh);
  for (auto& position : mesh.positions) position *= static_cast<float>(height_m);
  return mesh;
}

}  // namespace meshloop
