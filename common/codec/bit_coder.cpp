#include "common/codec/bit_coder.h"

#include <algorithm>
#include <utility>

namespace meshloop {
namespace {

constexpr std::uint32_t kEven = 32768;
constexpr std::uint32_t kTop = 1U << 24;
/// How often each value counts as seen before the first bit, in fifths: 0.4 (Krichevsky and Trofimov's is 0.5).
constexpr std::uint32_t kPrior = 2;
constexpr std::uint32_t kParts = 5;

}  // namespace

// The estimator of Krichevsky and Trofimov, with another prior; what is long ago counts less.
void ProbabilityModel::learn(bool bit) {
  constexpr std::uint32_t kMemory = 50;
  constexpr std::uint32_t kLeast = 128;
  const std::uint32_t divisor = kParts * (seen_ + 1) + 2 * kPrior;
  if (bit) {
    zero_ -= kParts * zero_ / divisor;
  } else {
    zero_ += kParts * (65536 - zero_) / divisor;
  }
  zero_ = std::clamp(zero_, kLeast, 65536 - kLeast);
  seen_ = std::min(seen_ + 1, kMemory);
}

void BitEncoder::encode(ProbabilityModel& model, bool bit) {
  narrow(bit, model.zero_of_65536());
  model.learn(bit);
}

void BitEncoder::encode_bypass(std::uint32_t value, int bits) {
  for (int i = 0; i < bits; ++i) narrow((value >> i & 1U) != 0, kEven);
}

void BitEncoder::narrow(bool bit, std::uint32_t zero_of_65536) {
  const std::uint32_t bound = (range_ >> 16) * zero_of_65536;
  if (bit) {
    low_ += bound;
    range_ -= bound;
  } else {
    range_ = bound;
  }
  while (range_ < kTop) {
    range_ <<= 8;
    shift_out();
  }
}

// A carry may still run through what is held: a byte, and bytes of 255 after it.
void BitEncoder::shift_out() {
  if (low_ < 0xff000000U || low_ > 0xffffffffU) {
    const auto carry = static_cast<std::uint8_t>(low_ >> 32);
    if (!is_first_) bytes_.push_back(static_cast<std::byte>(held_ + carry));
    is_first_ = false;
    bytes_.insert(bytes_.end(), held_count_, static_cast<std::byte>(0xff + carry));
    held_count_ = 0;
    held_ = static_cast<std::uint8_t>(low_ >> 24);
  } else {
    ++held_count_;
  }
  low_ = (low_ & 0x00ffffffU) << 8;
}

// Of all numbers that mean the same the one with the most zeros at its end, which need not be written.
std::vector<std::byte> BitEncoder::finish() {
  for (int zeros = 32; zeros >= 0; --zeros) {
    const std::uint64_t below = (std::uint64_t{1} << zeros) - 1;
    const std::uint64_t rounded = (low_ + below) & ~below;
    if (rounded >= low_ + range_) continue;
    low_ = rounded;
    break;
  }
  for (int i = 0; i < 5; ++i) shift_out();
  while (!bytes_.empty() && bytes_.back() == std::byte{0}) bytes_.pop_back();
  return std::move(bytes_);
}

BitDecoder::BitDecoder(std::span<const std::byte> bytes) : bytes_{bytes} {
  for (int i = 0; i < 4; ++i) shift_in();
}

bool BitDecoder::decode(ProbabilityModel& model) {
  const bool bit = narrow(model.zero_of_65536());
  model.learn(bit);
  return bit;
}

std::uint32_t BitDecoder::decode_bypass(int bits) {
  std::uint32_t value = 0;
  for (int i = 0; i < bits; ++i) value |= (narrow(kEven) ? 1U : 0U) << i;
  return value;
}

bool BitDecoder::narrow(std::uint32_t zero_of_65536) {
  const std::uint32_t bound = (range_ >> 16) * zero_of_65536;
  const bool bit = code_ >= bound;
  if (bit) {
    code_ -= bound;
    range_ -= bound;
  } else {
    range_ = bound;
  }
  while (range_ < kTop) {
    range_ <<= 8;
    shift_in();
  }
  return bit;
}

void BitDecoder::shift_in() {
  code_ = code_ << 8 | (next_ < bytes_.size() ? std::to_integer<std::uint32_t>(bytes_[next_]) : 0U);
  ++next_;
}

}  // namespace meshloop
