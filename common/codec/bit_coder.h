#pragma once
// Adaptive binary range coder (Martin 1979; with the carry of Schindler's and LZMA's): what follows after Draco's mesh
// is too little to pay for tables of frequencies, so these are learned from what was coded before. Integers only: the
// same bits on every machine.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace meshloop {

/// How likely the next bit of its context is zero, from those before.
class ProbabilityModel {
 public:
  [[nodiscard]] std::uint32_t zero_of_65536() const { return zero_; }
  void learn(bool bit);

 private:
  std::uint32_t zero_ = 32768;
  std::uint32_t seen_ = 0;
};

class BitEncoder {
 public:
  void encode(ProbabilityModel& model, bool bit);
  /// Bits without a model, as likely one as zero, lowest first.
  void encode_bypass(std::uint32_t value, int bits);
  /// The last byte is not zero. Nothing can be encoded afterwards.
  [[nodiscard]] std::vector<std::byte> finish();

 private:
  void narrow(bool bit, std::uint32_t zero_of_65536);
  void shift_out();

  std::uint64_t low_ = 0;
  std::uint32_t range_ = 0xffffffff;
  std::uint8_t held_ = 0;
  std::size_t held_count_ = 0;
  bool is_first_ = true;
  std::vector<std::byte> bytes_;
};

/// Takes any bytes, as if zeros came after them.
class BitDecoder {
 public:
  explicit BitDecoder(std::span<const std::byte> bytes);
  [[nodiscard]] bool decode(ProbabilityModel& model);
  [[nodiscard]] std::uint32_t decode_bypass(int bits);
  /// No byte is left that was not looked at.
  [[nodiscard]] bool is_at_end() const { return next_ >= bytes_.size(); }

 private:
  bool narrow(std::uint32_t zero_of_65536);
  void shift_in();

  std::span<const std::byte> bytes_;
  std::size_t next_ = 0;
  std::uint32_t code_ = 0;
  std::uint32_t range_ = 0xffffffff;
};

}  // namespace meshloop
