#include "common/interchange/gltf_container.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>

#include "common/interchange/mapped_file.h"

namespace meshloop {
namespace {

constexpr std::uint32_t kMagic = 0x46546C67;      // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinChunk = 0x004E4942;   // "BIN"
constexpr std::size_t kHeader = 12;
constexpr std::size_t kChunkHeader = 8;

std::uint32_t word_at(std::span<const std::byte> bytes, std::size_t offset) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + offset, sizeof word);
  return word;
}

void append_word(std::vector<std::byte>& bytes, std::size_t value) {
  const auto word = static_cast<std::uint32_t>(value);
  const auto view = std::as_bytes(std::span{&word, 1});
  bytes.insert(bytes.end(), view.begin(), view.end());
}

void append_chunk(std::vector<std::byte>& glb, std::uint32_t kind, std::span<const std::byte> content, char padding) {
  const std::size_t padded = (content.size() + 3) / 4 * 4;
  append_word(glb, padded);
  append_word(glb, kind);
  glb.insert(glb.end(), content.begin(), content.end());
  glb.insert(glb.end(), padded - content.size(), static_cast<std::byte>(padding));
}

/// "a%20b" as "a b".
std::string without_percents(std::string_view uri) {
  std::string plain;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const bool escaped = uri[i] == '%' && i + 2 < uri.size();
    if (escaped) {
      plain += static_cast<char>(std::strtol(std::string{uri.substr(i + 1, 2)}.c_str(), nullptr, 16));
      i += 2;
    } else {
      plain += uri[i];
    }
  }
  return plain;
}

Result<std::vector<std::byte>> bytes_of(const nlohmann::json& buffer, bool first, std::span<const std::byte> glb_chunk,
                                        const std::filesystem::path& folder) {
  if (!buffer.contains("uri")) {
    if (!first || glb_chunk.empty()) return fail("a buffer in it has no data");
    return std::vector<std::byte>(glb_chunk.begin(), glb_chunk.end());
  }
  const auto uri = buffer.at("uri").get<std::string>();
  if (uri.starts_with("data:")) {
    const auto comma = uri.find(";base64,");
    auto bytes = comma == std::string::npos ? std::nullopt : from_base64(std::string_view{uri}.substr(comma + 8));
    if (!bytes) return fail("a buffer in it is no base64 text");
    return std::move(*bytes);
  }
  const auto file = MappedFile::open(folder / without_percents(uri));
  if (!file) return fail(fmt::format("its buffer '{}'", uri), file.error());
  return std::vector<std::byte>(file->bytes().begin(), file->bytes().end());
}

}  // namespace

Result<GltfChunks> split_gltf(std::span<const std::byte> content) {
  const auto text = [](std::span<const std::byte> bytes) {
    return std::string_view{reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  };
  if (content.size() < kHeader || word_at(content, 0) != kMagic) return GltfChunks{text(content), {}};
  GltfChunks chunks;
  std::size_t at = kHeader;
  while (content.size() - at >= kChunkHeader) {
    const std::size_t size = word_at(content, at);
    const std::uint32_t kind = word_at(content, at + 4);
    at += kChunkHeader;
    if (size > content.size() - at) return fail("it ends within a chunk");
    if (kind == kJsonChunk) chunks.json = text(content.subspan(at, size));
    if (kind == kBinChunk) chunks.binary = content.subspan(at, size);
    at += size;
  }
  if (chunks.json.empty()) return fail("it has no JSON chunk");
  return chunks;
}

std::vector<std::byte> join_glb(const nlohmann::json& document, std::span<const std::byte> binary) {
  const std::string json = document.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  std::vector<std::byte> glb;
  glb.reserve(kHeader + 2 * kChunkHeader + json.size() + binary.size() + 8);
  append_word(glb, kMagic);
  append_word(glb, 2);
  append_word(glb, 0);
  append_chunk(glb, kJsonChunk, std::as_bytes(std::span{json}), ' ');
  append_chunk(glb, kBinChunk, binary, 0);
  const auto size = static_cast<std::uint32_t>(glb.size());
  std::memcpy(glb.data() + 8, &size, sizeof size);
  return glb;
}

std::optional<std::vector<std::byte>> from_base64(std::string_view text) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  while (text.ends_with('=')) text.remove_suffix(1);
  std::vector<std::byte> bytes;
  bytes.reserve(text.size() * 3 / 4);
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    const auto digit = kDigits.find(c);
    if (digit == std::string_view::npos) return std::nullopt;
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<std::byte>(bits >> count));
    bits &= (1u << count) - 1;
  }
  return bytes;
}

Result<std::vector<std::byte>> gather_buffers(nlohmann::json& document, std::span<const std::byte> glb_chunk,
                                              const std::filesystem::path& folder) {
  std::vector<std::byte> all;
  std::vector<std::size_t> starts;
  for (const auto& buffer : document.value("buffers", nlohmann::json::array())) {
    all.resize((all.size() + 3) / 4 * 4);
    const auto bytes = bytes_of(buffer, starts.empty(), glb_chunk, folder);
    if (!bytes) return fail(bytes.error());
    starts.push_back(all.size());
    all.insert(all.end(), bytes->begin(), bytes->end());
  }
  for (auto& view : document["bufferViews"]) {
    view["byteOffset"] = view.value("byteOffset", std::size_t{0}) + starts.at(view.at("buffer").get<std::size_t>());
    view["buffer"] = 0;
  }
  return all;
}

}  // namespace meshloop
