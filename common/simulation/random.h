#pragma once
// Random numbers that depend on (seed, index, stream) alone: the same whatever thread asks, in whatever order.
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

namespace meshloop::simulation {

/// Steele, Lea, Flood 2014, "Fast splittable pseudorandom number generators": the finaliser of SplitMix64.
[[nodiscard]] constexpr std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

[[nodiscard]] constexpr std::uint64_t random_bits(std::uint64_t seed, std::uint64_t index, std::uint64_t stream = 0) {
  return mix(mix(seed ^ (stream * 0xd1b54a32d192ed03ull)) + index * 0x9e3779b97f4a7c15ull);
}

/// In [0, 1).
[[nodiscard]] constexpr double to_unit(std::uint64_t bits) {
  return static_cast<double>(bits >> 11) * 0x1.0p-53;
}

[[nodiscard]] constexpr double random_unit(std::uint64_t seed, std::uint64_t index, std::uint64_t stream = 0) {
  return to_unit(random_bits(seed, index, stream));
}

/// Two independent numbers of the standard normal distribution (Box and Muller 1958).
[[nodiscard]] inline std::pair<double, double> random_normals(std::uint64_t seed, std::uint64_t index,
                                                              std::uint64_t stream) {
  const std::uint64_t bits = random_bits(seed, index, stream);
  const double radius = std::sqrt(-2 * std::log(1 - to_unit(bits)));
  const double angle = 2 * std::numbers::pi * to_unit(mix(bits));
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

}  // namespace meshloop::simulation
