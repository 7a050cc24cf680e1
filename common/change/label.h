#pragma once
// The labels of a comparison. Everything that a label is (its number, name, what it makes the operator do, its colours)
// stands in this table; the rule that assigns it stands in classify_rule.h beside it, which C++ and the shader share.
#include <array>
#include <cstdint>
#include <string_view>

#include "common/image/image.h"

namespace meshloop {

/// The numbers are those of the label images that leave the program; they never change.
enum class Label : std::uint8_t { unmeasured = 0, unmodelled = 1, closer = 2, farther = 3, agrees = 4, undecided = 5 };

/// What a label asks of the model.
enum class ChangeKind : std::uint8_t { none, insertion, removal };

/// How strongly a label's colour covers the picture.
enum class Opacity : std::uint8_t { transparent, by_difference, constant };

struct LabelInfo {
  Label label;
  std::string_view name;
  ChangeKind kind;
  Opacity opacity;
  Rgb8 paper_color;
  /// Okabe and Ito's colours, told apart with every common colour blindness.
  Rgb8 safe_color;
  std::string_view meaning;
};

inline constexpr std::array<LabelInfo, 6> kLabels{{
    {Label::unmeasured,
     "unmeasured",
     ChangeKind::none,
     Opacity::constant,
     {0, 160, 0},
     {0, 158, 115},
     "no depth measured"},
    {Label::unmodelled,
     "unmodelled",
     ChangeKind::insertion,
     Opacity::constant,
     {30, 80, 255},
     {0, 114, 178},
     "measured, not in the model"},
    {Label::closer,
     "closer",
     ChangeKind::insertion,
     Opacity::by_difference,
     {230, 20, 20},
     {213, 94, 0},
     "nearer than the model"},
    {Label::farther,
     "farther",
     ChangeKind::removal,
     Opacity::by_difference,
     {255, 220, 0},
     {240, 228, 66},
     "farther than the model"},
    {Label::agrees, "agrees", ChangeKind::none, Opacity::transparent, {0, 0, 0}, {0, 0, 0}, "within the threshold"},
    {Label::undecided,
     "undecided",
     ChangeKind::none,
     Opacity::transparent,
     {0, 0, 0},
     {0, 0, 0},
     "too uncertain to tell"},
}};

[[nodiscard]] constexpr const LabelInfo& info(Label label) {
  return kLabels[static_cast<std::size_t>(label)];
}
[[nodiscard]] constexpr ChangeKind kind_of(Label label) {
  return info(label).kind;
}
[[nodiscard]] constexpr bool is_change(Label label) {
  return kind_of(label) != ChangeKind::none;
}

}  // namespace meshloop
