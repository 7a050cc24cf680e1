#pragma once
#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "common/base/result.h"

namespace meshloop {

/// The two chunks of a GLB; `binary` is empty for a .gltf. Views into the content.
struct GltfChunks {
  std::string_view json;
  std::span<const std::byte> binary;
};

/// A GLB's chunks, or the whole text of a .gltf. Refuses chunks that do not fit the content.
[[nodiscard]] Result<GltfChunks> split_gltf(std::span<const std::byte> content);

/// A GLB of the document and one binary chunk.
[[nodiscard]] std::vector<std::byte> join_glb(const nlohmann::json& document, std::span<const std::byte> binary);

/// Bytes of a base64 text; nothing when it is none.
[[nodiscard]] std::optional<std::vector<std::byte>> from_base64(std::string_view text);

/// All of a document's buffers one after the other (the GLB's own chunk, `data:` URIs, files in `folder`), of which the
/// document then has a single one; its buffer views are moved to it.
[[nodiscard]] Result<std::vector<std::byte>> gather_buffers(nlohmann::json& document,
                                                            std::span<const std::byte> glb_chunk,
                                                            const std::filesystem::path& folder);

}  // namespace meshloop
