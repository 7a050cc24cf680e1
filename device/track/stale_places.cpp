#include "device/track/stale_places.h"

#include <algorithm>
#include <cmath>

namespace meshloop {
namespace {

constexpr double kPlace_m = 0.04;
/// How much of the mean a new frame makes up.
constexpr double kNewShare = 0.3;
/// A place is stale below the one and trusted again above the other.
constexpr double kStaleBelow = 0.4;
constexpr double kTrustedAbove = 0.65;
constexpr int kFramesToJudge = 4;

/// Cubes on each side of the origin, 42 km; what lies beyond shares the last one.
constexpr double kCubes = 1 << 20;

/// Of the cube that the point lies in.
std::uint64_t number_of(const Eigen::Vector3d& p_world) {
  std::uint64_t number = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double cube = std::clamp(std::floor(p_world(axis) / kPlace_m), -kCubes, kCubes - 1);
    number = (number << 21) | static_cast<std::uint64_t>(cube + kCubes);
  }
  return number;
}

struct Tally {
  int agreeing = 0;
  int all = 0;
};

}  // namespace

void StalePlaces::judge(const std::vector<Verdict>& verdicts) {
  std::unordered_map<std::uint64_t, Tally> tallies;
  for (const Verdict& verdict : verdicts) {
    Tally& tally = tallies[number_of(verdict.p_world)];
    tally.agreeing += verdict.agrees ? 1 : 0;
    ++tally.all;
  }
  for (const auto& [number, tally] : tallies) {
    Place& place = places_[number];
    ++place.frames;
    const double share = static_cast<double>(tally.agreeing) / tally.all;
    const double weight = std::max(kNewShare, 1.0 / place.frames);
    place.agreement += weight * (share - place.agreement);
    if (place.frames < kFramesToJudge) continue;
    place.stale = place.stale ? place.agreement <= kTrustedAbove : place.agreement < kStaleBelow;
  }
}

bool StalePlaces::contains(const Eigen::Vector3d& p_world) const {
  const auto place = places_.find(number_of(p_world));
  return place != places_.end() && place->second.stale;
}

}  // namespace meshloop
