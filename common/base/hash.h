#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace meshloop {

/// BLAKE2b, 256 bits: names a content. Two contents with one hash are the same content.
using Hash = std::array<std::uint8_t, 32>;

[[nodiscard]] Hash hash_of(std::span<const std::byte> bytes);
[[nodiscard]] std::string to_hex(const Hash& hash);

}  // namespace meshloop
