#include "common/codec/color_coder.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>

#include "common/codec/color_transform.h"

namespace meshloop {
namespace {

constexpr int kLearned = 16;
/// For what differs by more than kLearned: up to 128.
constexpr int kPlainBits = 7;

/// Differences of one component that came after like ones: is it zero, its sign, then a bit for each step more. A large
/// one ends in plain bits, so that no payload can ask for many bits a colour.
struct Kind {
  AdaptiveBit is_zero;
  AdaptiveBit is_negative;
  std::array<AdaptiveBit, kLearned> goes_on;

  AdaptiveBit& after(int steps) { return goes_on[static_cast<std::size_t>(steps - 1)]; }
};

void encode(BitEncoder& out, Kind& kind, int difference) {
  out.encode(kind.is_zero, difference == 0);
  if (difference == 0) return;
  out.encode(kind.is_negative, difference < 0);
  const int size = std::abs(difference);
  for (int steps = 1; steps <= std::min(size, kLearned); ++steps) out.encode(kind.after(steps), size > steps);
  if (size > kLearned) out.encode_plain(static_cast<std::uint32_t>(size - kLearned - 1), kPlainBits);
}

int decode(BitDecoder& in, Kind& kind) {
  if (in.decode(kind.is_zero)) return 0;
  const bool is_negative = in.decode(kind.is_negative);
  int size = 1;
  while (size <= kLearned && in.decode(kind.after(size))) ++size;
  if (size > kLearned) size += static_cast<int>(in.decode_plain(kPlainBits));
  return is_negative ? -size : size;
}

/// Which of the kinds the next difference belongs to. Neighbours differ most in brightness, and then red and blue
/// against green by what green did.
class Kinds {
 public:
  Kind& of_green() { return green_[static_cast<std::size_t>(std::min(std::abs(last_green_), 3))]; }
  Kind& of_red(int green) {
    last_green_ = green;
    return red_[static_cast<std::size_t>(std::clamp(green, -2, 2) + 2)];
  }
  Kind& of_blue(int green, int red) {
    return blue_[static_cast<std::size_t>(3 * (std::clamp(green, -1, 1) + 1) + std::clamp(red, -1, 1) + 1)];
  }

 private:
  std::array<Kind, 4> green_;
  std::array<Kind, 5> red_;
  std::array<Kind, 9> blue_;
  int last_green_ = 0;
};

constexpr CodedColor kFirst{128, 0, 128};

}  // namespace

int color_step(std::span<const Rgb8> colors) {
  const auto in_steps = [](const Rgb8& color) { return (color.r | color.g | color.b) % kCoarseColorStep == 0; };
  return std::all_of(colors.begin(), colors.end(), in_steps) ? kCoarseColorStep : 1;
}

void encode_colors(BitEncoder& out, std::span<const Rgb8> colors, int step) {
  Kinds kinds;
  CodedColor before = kFirst;
  for (const auto& color : colors) {
    const CodedColor coded = to_coded(color, step);
    const auto difference = [&](std::size_t k) { return int{static_cast<std::int8_t>(coded[k] - before[k])}; };
    const int green = difference(1);
    const int red = difference(0);
    encode(out, kinds.of_green(), green);
    encode(out, kinds.of_red(green), red);
    encode(out, kinds.of_blue(green, red), difference(2));
    before = coded;
  }
}

std::vector<Rgb8> decode_colors(BitDecoder& in, std::size_t count, int step) {
  Kinds kinds;
  CodedColor coded = kFirst;
  std::vector<Rgb8> colors;
  colors.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const int green = decode(in, kinds.of_green());
    const int red = decode(in, kinds.of_red(green));
    const int blue = decode(in, kinds.of_blue(green, red));
    coded = {static_cast<std::uint8_t>(coded[0] + red), static_cast<std::uint8_t>(coded[1] + green),
             static_cast<std::uint8_t>(coded[2] + blue)};
    colors.push_back(from_coded(coded, step));
  }
  return colors;
}

}  // namespace meshloop
