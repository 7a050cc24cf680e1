#pragma once
// The values that follow a PLY header, one after the other, as text or as bytes.
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "common/interchange/ply_header.h"

namespace meshloop {

/// Whitespace-separated numbers. After the end, or at something that is no number, every value is 0 and good() is
/// false.
class PlyTextValues {
 public:
  explicit PlyTextValues(std::string_view text) : rest_{text}, size_{text.size()} {}

  double next(PlyType) {
    const auto start = rest_.find_first_not_of(" \t\r\n");
    if (start == std::string_view::npos) return stop();
    rest_.remove_prefix(start);
    double value = 0;
    const auto parsed = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
    if (parsed.ec != std::errc{}) return stop();
    rest_.remove_prefix(static_cast<std::size_t>(parsed.ptr - rest_.data()));
    return value;
  }

  [[nodiscard]] bool good() const { return good_; }
  /// No more values than this can follow.
  [[nodiscard]] std::size_t most_left(PlyType) const { return (rest_.size() + 1) / 2; }
  [[nodiscard]] double share_done() const { return 1 - static_cast<double>(rest_.size()) / static_cast<double>(size_); }

 private:
  double stop() {
    good_ = false;
    rest_ = {};
    return 0;
  }

  std::string_view rest_;
  std::size_t size_;
  bool good_ = true;
};

/// Numbers as bytes; like PlyTextValues otherwise.
template <std::endian order>
class PlyByteValues {
 public:
  explicit PlyByteValues(std::string_view bytes) : rest_{bytes}, size_{bytes.size()} {}

  double next(PlyType type) {
    switch (type) {
      case PlyType::int8:
        return take<std::int8_t>();
      case PlyType::uint8:
        return take<std::uint8_t>();
      case PlyType::int16:
        return take<std::int16_t>();
      case PlyType::uint16:
        return take<std::uint16_t>();
      case PlyType::int32:
        return take<std::int32_t>();
      case PlyType::uint32:
        return take<std::uint32_t>();
      case PlyType::float32:
        return static_cast<double>(take<float>());
      case PlyType::float64:
        return take<double>();
    }
    return 0;
  }

  [[nodiscard]] bool good() const { return good_; }
  [[nodiscard]] std::size_t most_left(PlyType type) const { return rest_.size() / size_of(type); }
  [[nodiscard]] double share_done() const { return 1 - static_cast<double>(rest_.size()) / static_cast<double>(size_); }

 private:
  template <class T>
  T take() {
    std::array<char, sizeof(T)> bytes{};
    if (rest_.size() < bytes.size()) {
      good_ = false;
      rest_ = {};
      return T{};
    }
    std::memcpy(bytes.data(), rest_.data(), bytes.size());
    rest_.remove_prefix(bytes.size());
    if constexpr (order != std::endian::native) std::reverse(bytes.begin(), bytes.end());
    return std::bit_cast<T>(bytes);
  }

  std::string_view rest_;
  std::size_t size_;
  bool good_ = true;
};

}  // namespace meshloop
