// glTF whose meshes are compressed with Draco, made with Draco's own encoder as exporters do.
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>

#include <nlohmann/json.hpp>

#include "common/interchange/gltf_container.h"
#include "common/interchange/model_file.h"
#include "files.h"

namespace meshloop {
namespace {

using Json = nlohmann::json;

struct Payload {
  std::vector<std::byte> bytes;
  int position_id = 0;
  int color_id = 0;
};

/// Positions in 16 bits over 4 m (0.03 mm), normals, and colours with opacity.
Payload compressed(const Submesh& mesh) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(static_cast<int>(mesh.triangles.size()));
  const int normal = builder.AddAttribute(draco::GeometryAttribute::NORMAL, 3, draco::DT_FLOAT32);
  const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int color = builder.AddAttribute(draco::GeometryAttribute::COLOR, 4, draco::DT_UINT8);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const draco::FaceIndex face(static_cast<std::uint32_t>(t));
    const auto& [a, b, c] = mesh.triangles[t];
    const Eigen::Vector3f up{0, 0, 1};
    builder.SetAttributeValuesForFace(normal, face, up.data(), up.data(), up.data());
    builder.SetAttributeValuesForFace(position, face, mesh.positions[a].data(), mesh.positions[b].data(),
                                      mesh.positions[c].data());
    std::array<std::array<std::uint8_t, 4>, 3> rgba;
    for (std::size_t k = 0; k < 3; ++k) {
      const Rgb8& rgb = mesh.colors[mesh.triangles[t][k]];
      rgba[k] = {rgb.r, rgb.g, rgb.b, 255};
    }
    builder.SetAttributeValuesForFace(color, face, rgba[0].data(), rgba[1].data(), rgba[2].data());
  }
  const auto built = builder.Finalize();
  draco::Encoder encoder;
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 16);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeMeshToBuffer(*built, &buffer).ok()) return {};
  const auto* first = reinterpret_cast<const std::byte*>(buffer.data());
  return {{first, first + buffer.size()},
          static_cast<int>(built->attribute(position)->unique_id()),
          static_cast<int>(built->attribute(color)->unique_id())};
}

Json document_of(const Payload& payload) {
  Json document = Json::parse(R"({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "extensionsUsed": ["KHR_draco_mesh_compression"], "extensionsRequired": ["KHR_draco_mesh_compression"],
    "nodes": [{"mesh": 0, "name": "wall", "translation": [0, 0, 2]}],
    "meshes": [{"name": "wall", "primitives": [{
      "attributes": {"POSITION": 1, "COLOR_0": 2, "NORMAL": 3}, "indices": 0, "mode": 4,
      "extensions": {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {}}}}]}],
    "accessors": [{"componentType": 5125, "count": 3, "type": "SCALAR"},
                  {"componentType": 5126, "count": 3, "type": "VEC3"},
                  {"componentType": 5121, "normalized": true, "count": 3, "type": "VEC4"},
                  {"componentType": 5126, "count": 3, "type": "VEC3"}],
    "bufferViews": [{"buffer": 0}], "buffers": [{}]})");
  auto& extension = document["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"];
  extension["attributes"] = {{"POSITION", payload.position_id}, {"COLOR_0", payload.color_id}};
  document["bufferViews"][0]["byteLength"] = payload.bytes.size();
  document["buffers"][0]["byteLength"] = payload.bytes.size();
  return document;
}

/// glTF states colours as linear light, so only black and white are the same bytes there and here.
Submesh black_and_white_grid() {
  Submesh mesh = test::grid(12);
  for (std::size_t i = 0; i < mesh.colors.size(); ++i) {
    const auto value = static_cast<std::uint8_t>(i % 2 == 0 ? 255 : 0);
    mesh.colors[i] = {value, value, 0};
  }
  return mesh;
}

class GltfDraco : public test::Folder {
 protected:
  void expect_grid(const std::filesystem::path& file) const {
    const auto model = import_as_model(file);
    ASSERT_TRUE(model) << model.error().message;
    ASSERT_EQ(model->model.nodes.size(), 1u);
    EXPECT_EQ(model->model.nodes[0].name, "wall");
    EXPECT_EQ(model->unit.source, LengthUnit::Source::stated);
    // Quantisation moves a vertex by less than the lattice's spacing: snapped it is where it was, 2 m behind.
    Submesh expected = black_and_white_grid();
    for (auto& p : expected.positions) p.z() += 2;
    const Submesh& found = *model->model.nodes[0].submesh;
    EXPECT_TRUE(test::faces_of(found) == test::faces_of(expected));
  }
};

TEST_F(GltfDraco, ReadsAGlb) {
  const Payload payload = compressed(black_and_white_grid());
  const auto glb = join_glb(document_of(payload), payload.bytes);
  expect_grid(write("a.glb", {reinterpret_cast<const char*>(glb.data()), glb.size()}));
}

TEST_F(GltfDraco, ReadsAGltfWithItsBufferBesideItOrInIt) {
  const Payload payload = compressed(black_and_white_grid());
  Json document = document_of(payload);
  write("a buffer.bin", {reinterpret_cast<const char*>(payload.bytes.data()), payload.bytes.size()});
  document["buffers"][0]["uri"] = "a%20buffer.bin";
  expect_grid(write("a.gltf", document.dump()));
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text = "data:application/octet-stream;base64,";
  for (std::size_t i = 0; i < payload.bytes.size(); i += 3) {
    unsigned bits = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      bits = bits << 8 | (i + k < payload.bytes.size() ? std::to_integer<unsigned>(payload.bytes[i + k]) : 0);
    }
    for (std::size_t k = 0; k < 4; ++k) text += i + k > payload.bytes.size() ? '=' : kDigits[bits >> (18 - 6 * k) & 63];
  }
  document["buffers"][0]["uri"] = text;
  expect_grid(write("b.gltf", document.dump()));
}

TEST_F(GltfDraco, RefusesDamageWithOneSentence) {
  Payload payload = compressed(black_and_white_grid());
  const auto refusal = [&](const Json& document) {
    const auto glb = join_glb(document, payload.bytes);
    const auto parts = import_model(write("a.glb", {reinterpret_cast<const char*>(glb.data()), glb.size()}));
    return parts ? std::string{} : parts.error().message;
  };
  Json document = document_of(payload);
  document["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["attributes"]["POSITION"] = 77;
  EXPECT_NE(refusal(document).find("lacks the positions"), std::string::npos);
  document = document_of(payload);
  document["bufferViews"][0]["byteLength"] = payload.bytes.size() + 9;
  EXPECT_NE(refusal(document).find("too short"), std::string::npos);
  document = document_of(payload);
  document["bufferViews"][0]["buffer"] = 3;
  EXPECT_NE(refusal(document).find("could not be read"), std::string::npos);
  document = document_of(payload);
  document["meshes"][0].erase("primitives");
  EXPECT_NE(refusal(document).find("JSON"), std::string::npos);
  document = document_of(payload);
  payload.bytes.resize(payload.bytes.size() / 2);
  document["bufferViews"][0]["byteLength"] = payload.bytes.size();
  EXPECT_NE(refusal(document).find("damaged"), std::string::npos);
}

TEST_F(GltfDraco, RefusesWhatItCannotReadByName) {
  const Payload payload = compressed(black_and_white_grid());
  Json document = document_of(payload);
  document["extensionsRequired"].push_back("KHR_mesh_quantization");
  const auto glb = join_glb(document, payload.bytes);
  const auto parts = import_model(write("a.glb", {reinterpret_cast<const char*>(glb.data()), glb.size()}));
  ASSERT_FALSE(parts);
  EXPECT_NE(parts.error().message.find("KHR_mesh_quantization"), std::string::npos);
}

TEST(GltfContainer, Base64) {
  const auto text_of = [](std::string_view text) {
    const auto bytes = from_base64(text);
    return bytes ? std::string{reinterpret_cast<const char*>(bytes->data()), bytes->size()} : "none";
  };
  EXPECT_EQ(text_of("Zm9vYmFy"), "foobar");
  EXPECT_EQ(text_of("Zm9vYg=="), "foob");
  EXPECT_EQ(text_of(""), "");
  EXPECT_EQ(text_of("Zm9*"), "none");
}

}  // namespace
}  // namespace meshloop
