#include "common/codec/texture_frame.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

namespace meshloop {
namespace {

static_assert(std::endian::native == std::endian::little, "values are written as they lie in memory");

constexpr std::array kMagic{std::byte{'M'}, std::byte{'T'}, std::byte{'X'}, std::byte{'1'}};
constexpr std::size_t kProjectionBytes = 12 * sizeof(float);
constexpr std::size_t kHeaderBytes = kMagic.size() + sizeof(std::uint32_t) + kProjectionBytes;

void append(std::vector<std::byte>& bytes, std::span<const std::byte> more) {
  bytes.insert(bytes.end(), more.begin(), more.end());
}

}  // namespace

bool is_texture_frame(std::span<const std::byte> payload) {
  return payload.size() >= kMagic.size() && std::equal(kMagic.begin(), kMagic.end(), payload.begin());
}

Result<TextureFrame> split_texture_frame(std::span<const std::byte> payload) {
  if (!is_texture_frame(payload)) return fail("the payload has no texture");
  if (payload.size() < kHeaderBytes) return fail("the payload ends within its header");
  std::uint32_t mesh_bytes = 0;
  std::memcpy(&mesh_bytes, payload.data() + kMagic.size(), sizeof mesh_bytes);
  TextureFrame frame;
  std::memcpy(frame.projection.data(), payload.data() + kMagic.size() + sizeof mesh_bytes, kProjectionBytes);
  const auto parts = payload.subspan(kHeaderBytes);
  if (mesh_bytes > parts.size()) return fail("the payload ends within its mesh");
  frame.mesh = parts.first(mesh_bytes);
  frame.jpeg = parts.subspan(mesh_bytes);
  return frame;
}

std::vector<std::byte> join_texture_frame(std::span<const std::byte> mesh, const ProjectedTexture& texture) {
  const auto mesh_bytes = static_cast<std::uint32_t>(mesh.size());
  std::vector<std::byte> payload;
  payload.reserve(kHeaderBytes + mesh.size() + texture.jpeg.size());
  append(payload, kMagic);
  append(payload, std::as_bytes(std::span{&mesh_bytes, 1}));
  append(payload, std::as_bytes(std::span{texture.projection.data(), 12}));
  append(payload, mesh);
  append(payload, texture.jpeg);
  return payload;
}

}  // namespace meshloop
