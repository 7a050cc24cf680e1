#include "common/interchange/gltf_texture.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/image/jpeg_codec.h"

namespace meshloop {
namespace {

using Json = nlohmann::json;

Result<std::span<const std::byte>> picture_of(const Json& document, const Json& material,
                                              std::span<const std::byte> chunk) {
  const auto texture = material.at("pbrMetallicRoughness").at("baseColorTexture").at("index").get<std::size_t>();
  const auto source = document.at("textures").at(texture).at("source").get<std::size_t>();
  const auto number = document.at("images").at(source).at("bufferView").get<std::size_t>();
  const Json& view = document.at("bufferViews").at(number);
  const auto offset = view.value("byteOffset", std::size_t{0});
  const auto length = view.at("byteLength").get<std::size_t>();
  if (view.at("buffer").get<std::size_t>() != 0 || offset > chunk.size() || length > chunk.size() - offset) {
    return fail("a texture in it lies beyond its data");
  }
  return chunk.subspan(offset, length);
}

Result<std::shared_ptr<const ProjectedTexture>> texture_of(const Json& document, const Json& material,
                                                           std::span<const std::byte> chunk) {
  const auto values = material.at("extras").at(kProjectionKey).get<std::vector<float>>();
  TextureProjection projection;
  if (values.size() != static_cast<std::size_t>(projection.size()))
    return fail("a texture's projection has 12 numbers");
  std::copy(values.begin(), values.end(), projection.data());
  const auto bytes = picture_of(document, material, chunk);
  if (!bytes) return fail(bytes.error());
  if (const auto picture = decode_jpeg(*bytes); !picture) return fail("a texture in it", picture.error());
  return make_projected_texture({bytes->begin(), bytes->end()}, projection);
}

}  // namespace

Result<GltfTextures> read_projected_textures(const GltfChunks& chunks) {
  GltfTextures textures;
  if (chunks.json.find(kProjectionKey) == std::string_view::npos) return textures;
  try {
    const auto document = Json::parse(chunks.json);
    std::map<std::string, int> uses;
    for (const auto& material : document.value("materials", Json::array())) ++uses[material.value("name", "")];
    for (const auto& material : document.value("materials", Json::array())) {
      if (!material.contains("extras") || !material["extras"].contains(kProjectionKey)) continue;
      const auto name = material.value("name", "");
      if (name.empty() || uses[name] > 1) return fail("a material with a projected texture has no name of its own");
      auto texture = texture_of(document, material, chunks.binary);
      if (!texture) return fail(texture.error());
      textures.emplace(name, std::move(*texture));
    }
  } catch (const Json::exception& error) {
    return fail(fmt::format("its JSON is not what glTF asks for ({})", error.what()));
  }
  return textures;
}

}  // namespace meshloop
