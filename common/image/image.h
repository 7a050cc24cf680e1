#pragma once
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace meshloop {

struct Rgb8 {
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;
  friend bool operator==(const Rgb8&, const Rgb8&) = default;
};

/// Pixels somewhere else; rows follow each other without gaps. Row 0 is the top row.
template <class T>
class ImageView {
 public:
  ImageView() = default;
  ImageView(T* pixels, int width, int height) : pixels_{pixels}, width_{width}, height_{height} {}

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] bool empty() const { return width_ == 0 || height_ == 0; }
  [[nodiscard]] std::size_t size() const {
    return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  }
  [[nodiscard]] T* data() const { return pixels_; }
  [[nodiscard]] std::span<T> pixels() const { return {pixels_, size()}; }
  [[nodiscard]] T& operator()(int x, int y) const {
    assert(x >= 0 && y >= 0 && x < width_ && y < height_);
    return pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
  }

 private:
  T* pixels_ = nullptr;
  int width_ = 0;
  int height_ = 0;
};

/// An image that owns its pixels.
template <class T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, T value = T{})
      : pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), value),
        width_{width},
        height_{height} {}

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] bool empty() const { return pixels_.empty(); }
  [[nodiscard]] std::size_t size() const { return pixels_.size(); }
  [[nodiscard]] T* data() { return pixels_.data(); }
  [[nodiscard]] const T* data() const { return pixels_.data(); }
  [[nodiscard]] std::span<T> pixels() { return pixels_; }
  [[nodiscard]] std::span<const T> pixels() const { return pixels_; }
  [[nodiscard]] T& operator()(int x, int y) { return view()(x, y); }
  [[nodiscard]] const T& operator()(int x, int y) const { return view()(x, y); }
  [[nodiscard]] ImageView<T> view() { return {pixels_.data(), width_, height_}; }
  [[nodiscard]] ImageView<const T> view() const { return {pixels_.data(), width_, height_}; }

  friend bool operator==(const Image&, const Image&) = default;

 private:
  std::vector<T> pixels_;
  int width_ = 0;
  int height_ = 0;
};

using ColorImage = Image<Rgb8>;
using GreyImage = Image<std::uint8_t>;
/// Metres along the optical axis; 0 where nothing was measured (or, in a rendered image, where no surface is).
using DepthImage = Image<float>;

/// Luma of ITU-R BT.601, rounded.
[[nodiscard]] GreyImage to_grey(const ColorImage& color);
/// The same grey in all three channels.
[[nodiscard]] ColorImage to_color(const GreyImage& grey);

}  // namespace meshloop
