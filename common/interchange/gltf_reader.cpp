#include "common/interchange/gltf_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "common/codec/foreign_draco.h"
#include "common/interchange/gltf_container.h"
#include "common/interchange/gltf_texture.h"
#include "common/interchange/mapped_file.h"
#include "common/interchange/scene_reader.h"

namespace meshloop {
namespace {

using Json = nlohmann::json;

constexpr const char* kDraco = "KHR_draco_mesh_compression";
constexpr int kUnsignedInt = 5125;
constexpr int kFloat = 5126;
constexpr int kTriangles = 4;

/// A document whose compressed primitives become plain ones, as if the file had never been compressed: assimp's own
/// decoding ends in an error.
class Decompressor {
 public:
  Decompressor(Json document, std::vector<std::byte> binary)
      : document_(std::move(document)), binary_{std::move(binary)} {}

  Status run(const Progress& progress) {
    double done = 0;
    auto& meshes = document_.at("meshes");
    for (auto& mesh : meshes) {
      for (auto& primitive : mesh.at("primitives")) {
        if (!primitive.contains("extensions") || !primitive["extensions"].contains(kDraco)) continue;
        if (auto ok = decompress(primitive); !ok) return ok;
      }
      progress(++done / static_cast<double>(meshes.size()));
    }
    for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
      if (!document_.contains(list)) continue;
      auto& names = document_[list];
      names.erase(std::remove(names.begin(), names.end(), Json(kDraco)), names.end());
      if (names.empty()) document_.erase(list);
    }
    return {};
  }

  [[nodiscard]] std::vector<std::byte> glb() {
    document_["buffers"] = Json::array({{{"byteLength", binary_.size()}}});
    return join_glb(document_, binary_);
  }

 private:
  Status decompress(Json& primitive) {
    const Json extension = primitive["extensions"][kDraco];
    const auto payload = view_bytes(document_.at("bufferViews").at(extension.at("bufferView").get<std::size_t>()));
    if (!payload) return fail(payload.error());
    const Json& ids = extension.at("attributes");
    ForeignAttributes attributes{ids.at("POSITION").get<std::uint32_t>(), std::nullopt};
    if (ids.contains("COLOR_0")) attributes.color = ids["COLOR_0"].get<std::uint32_t>();
    const auto mesh =
        decode_foreign(*payload, attributes,
                       {.max_bytes = payload->size(), .max_vertices = kMaxVertices, .max_triangles = kMaxTriangles});
    if (!mesh) return fail(mesh.error());
    primitive["mode"] = kTriangles;
    primitive["indices"] =
        accessor("SCALAR", kUnsignedInt, 3 * mesh->triangles.size(), std::as_bytes(std::span{mesh->triangles}));
    // Normals and texture coordinates would only be dropped later.
    primitive["attributes"] = {
        {"POSITION", accessor("VEC3", kFloat, mesh->positions.size(), std::as_bytes(std::span{mesh->positions}))}};
    if (!mesh->colors.empty()) {
      primitive["attributes"]["COLOR_0"] =
          accessor("VEC4", kFloat, mesh->colors.size(), std::as_bytes(std::span{mesh->colors}));
    }
    primitive["extensions"].erase(kDraco);
    return {};
  }

  /// A copy, since accessors are appended to the buffer.
  Result<std::vector<std::byte>> view_bytes(const Json& view) const {
    const auto offset = view.value("byteOffset", std::size_t{0});
    const auto length = view.at("byteLength").get<std::size_t>();
    if (offset > binary_.size() || length > binary_.size() - offset) return fail("a buffer in it is too short");
    const auto bytes = std::span{binary_}.subspan(offset, length);
    return std::vector<std::byte>(bytes.begin(), bytes.end());
  }

  std::size_t accessor(const char* type, int component, std::size_t count, std::span<const std::byte> values) {
    binary_.resize((binary_.size() + 3) / 4 * 4);
    auto& views = document_["bufferViews"];
    views.push_back({{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", values.size()}});
    binary_.insert(binary_.end(), values.begin(), values.end());
    auto& accessors = document_["accessors"];
    accessors.push_back(
        {{"bufferView", views.size() - 1}, {"componentType", component}, {"count", count}, {"type", type}});
    return accessors.size() - 1;
  }

  Json document_;
  std::vector<std::byte> binary_;
};

Result<std::vector<std::byte>> without_draco(const GltfChunks& chunks, const std::filesystem::path& folder,
                                             const Progress& progress) {
  try {
    auto document = Json::parse(chunks.json);
    auto binary = gather_buffers(document, chunks.binary, folder);
    if (!binary) return fail(binary.error());
    Decompressor decompressor{std::move(document), std::move(*binary)};
    if (auto ok = decompressor.run(progress); !ok) return fail(ok.error());
    return decompressor.glb();
  } catch (const Json::exception& error) {
    return fail(fmt::format("its JSON is not what glTF asks for ({})", error.what()));
  }
}

/// Geometry that an extension encodes in another way would be read wrong.
Status check_extensions(std::string_view text) {
  const auto document = Json::parse(text, nullptr, false);
  if (!document.is_object() || !document.contains("extensionsRequired")) return {};
  for (const auto& name : document["extensionsRequired"]) {
    const auto extension = name.is_string() ? name.get<std::string>() : std::string{};
    const bool is_look = extension.starts_with("KHR_materials_") || extension.starts_with("KHR_texture_") ||
                         extension.starts_with("EXT_texture_") || extension.starts_with("KHR_lights_");
    if (is_look || extension == kDraco) continue;
    return fail(fmt::format("it needs the glTF extension {}, which is not read; export it without", extension));
  }
  return {};
}

}  // namespace

Result<ReadParts> read_gltf(const std::filesystem::path& file, const Progress& progress) {
  const auto content = MappedFile::open(file);
  if (!content) return fail(content.error());
  const auto chunks = split_gltf(content->bytes());
  if (!chunks) return fail(chunks.error());
  if (auto ok = check_extensions(chunks->json); !ok) return fail(ok.error());
  const auto read = [&]() -> Result<ReadParts> {
    const auto textures = read_projected_textures(*chunks);
    if (!textures) return fail(textures.error());
    if (chunks->json.find(kDraco) == std::string_view::npos) {
      // From memory only where it has to be: a .gltf may name other files.
      if (textures->empty()) return read_with_assimp(file, progress);
      return read_glb_with_assimp(content->bytes(), file, *textures, progress);
    }
    const auto glb = without_draco(*chunks, file.parent_path(), progress);
    if (!glb) return fail(glb.error());
    return read_glb_with_assimp(*glb, file, *textures, progress);
  };
  auto parts = read();
  if (parts) parts->unit = {1, LengthUnit::Source::stated};
  return parts;
}

}  // namespace meshloop
