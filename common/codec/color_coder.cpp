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
constexpr int kBypassBits = 7;

/// The models of one component's deltas that came after like ones: is it zero, its sign, then a bit for each step more.
/// A large one ends in bypass bits, so that no payload can ask for many bits a colour.
struct Context {
  ProbabilityModel is_zero;
  ProbabilityModel is_negative;
  std::array<ProbabilityModel, kLearned> goes_on;

  ProbabilityModel& after(int steps) { return goes_on[static_cast<std::size_t>(steps - 1)]; }
};

void encode(BitEncoder& out, Context& context, int delta) {
  out.encode(context.is_zero, delta == 0);
  if (delta == 0) return;
  out.encode(context.is_negative, delta < 0);
  const int size = std::abs(delta);
  for (int steps = 1; steps <= std::min(size, kLearned); ++steps) out.encode(context.after(steps), size > steps);
  if (size > kLearned) out.encode_bypass(static_cast<std::uint32_t>(size - kLearned - 1), kBypassBits);
}

int decode(BitDecoder& in, Context& context) {
  if (in.decode(context.is_zero)) return 0;
  const bool is_negative = in.decode(context.is_negative);
  int size = 1;
  while (size <= kLearned && in.decode(context.after(size))) ++size;
  if (size > kLearned) size += static_cast<int>(in.decode_bypass(kBypassBits));
  return is_negative ? -size : size;
}

/// Which context the next delta is coded in. Neighbours differ most in brightness, and then red and blue
/// against green by what green did.
class Contexts {
 public:
  Context& of_green() { return green_[static_cast<std::size_t>(std::min(std::abs(last_green_), 3))]; }
  Context& of_red(int green) { return red_[static_cast<std::size_t>(std::clamp(green, -2, 2) + 2)]; }
  Context& of_blue(int green, int red) {
    return blue_[static_cast<std::size_t>(3 * (std::clamp(green, -1, 1) + 1) + std::clamp(red, -1, 1) + 1)];
  }
  /// Call after each vertex.
  void set_last_green(int green) { last_green_ = green; }

 private:
  std::array<Context, 4> green_;
  std::array<Context, 5> red_;
  std::array<Context, 9> blue_;
  int last_green_ = 0;
};

constexpr CodedColor kFirst{128, 0, 128};

}  // namespace

int color_step(std::span<const Rgb8> colors) {
  const auto in_steps = [](const Rgb8& color) { return (color.r | color.g | color.b) % kCoarseColorStep == 0; };
  return std::all_of(colors.begin(), colors.end(), in_steps) ? kCoarseColorStep : 1;
}

void encode_colors(BitEncoder& out, std::span<const Rgb8> colors, int step) {
  Contexts contexts;
  CodedColor before = kFirst;
  for (const auto& color : colors) {
    const CodedColor coded = to_coded(color, step);
    const auto delta = [&](std::size_t k) { return int{static_cast<std::int8_t>(coded[k] - before[k])}; };
    const int green = delta(1);
    const int red = delta(0);
    encode(out, contexts.of_green(), green);
    encode(out, contexts.of_red(green), red);
    encode(out, contexts.of_blue(green, red), delta(2));
    contexts.set_last_green(green);
    before = coded;
  }
}

std::vector<Rgb8> decode_colors(BitDecoder& in, std::size_t count, int step) {
  Contexts contexts;
  CodedColor coded = kFirst;
  std::vector<Rgb8> colors;
  colors.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const int green = decode(in, contexts.of_green());
    const int red = decode(in, contexts.of_red(green));
    const int blue = decode(in, contexts.of_blue(green, red));
    contexts.set_last_green(green);
    coded = {static_cast<std::uint8_t>(coded[0] + red), static_cast<std::uint8_t>(coded[1] + green),
             static_cast<std::uint8_t>(coded[2] + blue)};
    colors.push_back(from_coded(coded, step));
  }
  return colors;
}

}  // namespace meshloop
