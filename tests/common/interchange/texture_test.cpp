// Textures in files of models.
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "common/interchange/gltf_container.h"
#include "common/interchange/model_file.h"
#include "common/interchange/texture_coordinates.h"
#include "common/interchange/writers.h"
#include "files.h"
#include "textured_wall.h"

namespace meshloop {
namespace {

using test::textured_wall;

class TextureFile : public test::Folder {
 protected:
  ImportedModel round_trip(const Model& model, const std::string& name, const ImportOptions& options = {}) const {
    EXPECT_TRUE(export_model(model, path(name)));
    auto imported = import_as_model(path(name), options);
    EXPECT_TRUE(imported) << imported.error().message;
    return imported ? std::move(*imported) : ImportedModel{};
  }
};

Model model_of(const Submesh& submesh, const Pose& T_world_node = Pose::Identity()) {
  Model model;
  model.nodes.push_back(make_node(1, "wall", submesh, T_world_node));
  return model;
}

Pose turned() {
  return make_pose({0.5, -0.25, 2}, Eigen::Quaterniond{Eigen::AngleAxisd{0.7, Eigen::Vector3d{1, 2, 3}.normalized()}});
}

/// Largest distance in pixels of the texture between where a point lies by the mesh's coordinates, evenly interpolated,
/// and where it should.
float largest_error_px(const TexturedMesh& mesh, const ProjectedTexture& texture) {
  const Eigen::Array2f size{static_cast<float>(texture.width), static_cast<float>(texture.height)};
  float worst = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    for (int i = 0; i <= 8; ++i) {
      for (int k = 0; k + i <= 8; ++k) {
        const float s = static_cast<float>(i) / 8, t = static_cast<float>(k) / 8;
        const Eigen::Vector3f p = (1 - s - t) * mesh.positions[a] + s * mesh.positions[b] + t * mesh.positions[c];
        const Eigen::Array2f at =
            ((1 - s - t) * mesh.coordinates[a] + s * mesh.coordinates[b] + t * mesh.coordinates[c]).array();
        worst = std::max(worst, ((at * size - 0.5f).matrix() - pixel_of(texture, p)).norm());
      }
    }
  }
  return worst;
}

TEST(TextureCoordinates, AreRightWithinAPixelAcrossTriangles) {
  const Submesh wall = textured_wall();
  const auto mesh = with_coordinates(wall);
  EXPECT_GT(mesh.triangles.size(), 8u);
  EXPECT_LT(mesh.triangles.size(), 400u);
  EXPECT_LT(largest_error_px(mesh, *wall.texture), 0.75f);
  TexturedMesh undivided{wall.positions, {}, wall.triangles};
  for (const auto& p : wall.positions) {
    const Eigen::Array2f pixel = pixel_of(*wall.texture, p).array();
    undivided.coordinates.emplace_back((pixel + 0.5f) / Eigen::Array2f{160, 120});
  }
  EXPECT_GT(largest_error_px(undivided, *wall.texture), 5.0f);
}

/// Every edge inside has a triangle on both sides, and the area stays.
TEST(TextureCoordinates, OpenNoCracks) {
  const Submesh wall = textured_wall();
  const auto mesh = with_coordinates(wall);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
  float area = 0;
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) ++uses[std::minmax(triangle[k], triangle[(k + 1) % 3])];
    const auto& p = mesh.positions[triangle[0]];
    const Eigen::Vector3f twice = (mesh.positions[triangle[1]] - p).cross(mesh.positions[triangle[2]] - p);
    EXPECT_GT(twice.z(), 0) << "turned over";
    area += twice.norm() / 2;
  }
  EXPECT_NEAR(area, 1.5f, 1e-4f);
  for (const auto& [edge, count] : uses) {
    const auto &a = mesh.positions[edge.first], &b = mesh.positions[edge.second];
    const bool on_border = (std::abs(a.x()) == 0.75f && a.x() == b.x()) || (std::abs(a.y()) == 0.5f && a.y() == b.y());
    EXPECT_EQ(count, on_border ? 1 : 2);
  }
}

/// Two triangles that meet without sharing vertices, as where a surface was cut in pieces.
TEST(TextureCoordinates, DivideEdgesOfTwoPiecesAlike) {
  const Submesh wall = textured_wall();
  const auto places = [&](const std::vector<bool>& keep) {
    std::set<std::array<float, 3>> on_diagonal;
    for (const auto& p : with_coordinates(keep_triangles(wall, keep)).positions) {
      if (std::abs(p.y() * 1.5f - p.x()) < 1e-5f) on_diagonal.insert({p.x(), p.y(), p.z()});
    }
    return on_diagonal;
  };
  EXPECT_GT(places({true, false}).size(), 3u);
  EXPECT_EQ(places({true, false}), places({false, true}));
}

TEST(TextureCoordinates, EndWithAProjectionThatNeverFits) {
  // Nearly edge on: pixels run away towards one side.
  Submesh wall = textured_wall();
  auto texture = std::make_shared<ProjectedTexture>(*wall.texture);
  texture->projection << 1e8F, 0, 0, 0, 0, 1e8F, 0, 0, 1, 0, 0, 0.7500001F;
  wall.texture = texture;
  ASSERT_TRUE(validate(wall));
  const auto mesh = with_coordinates(wall);
  EXPECT_LE(mesh.triangles.size(), 4u * 2u * 160u * 120u);
}

TEST_F(TextureFile, GlbBringsThePictureBackByteForByteWithItsProjection) {
  const Submesh wall = textured_wall();
  const auto imported = round_trip(model_of(wall, turned()), "a.glb");
  ASSERT_EQ(imported.model.nodes.size(), 1u);
  const Submesh& read = *imported.model.nodes[0].submesh;
  ASSERT_TRUE(read.texture);
  EXPECT_EQ(read.texture->jpeg, wall.texture->jpeg);
  EXPECT_FALSE(read.has_colors());
  // The import carries the node to the world, and its projection with it.
  for (const auto& p : wall.positions) {
    const Eigen::Vector3f there = (turned() * p.cast<double>()).cast<float>();
    EXPECT_LT((pixel_of(*read.texture, there) - pixel_of(*wall.texture, p)).norm(), 0.01f);
  }
}

TEST_F(TextureFile, GlbStatesWhatOtherProgramsNeed) {
  const auto glb = to_glb(model_of(textured_wall()));
  ASSERT_TRUE(glb) << glb.error().message;
  const auto chunks = split_gltf(*glb).value();
  const auto document = nlohmann::json::parse(chunks.json);
  const auto& primitive = document["meshes"][0]["primitives"][0];
  const auto& material = document["materials"][primitive["material"].get<std::size_t>()];
  const auto texture = material["pbrMetallicRoughness"]["baseColorTexture"]["index"].get<std::size_t>();
  const auto& image = document["images"][document["textures"][texture]["source"].get<std::size_t>()];
  EXPECT_EQ(image["mimeType"], "image/jpeg");
  const auto& view = document["bufferViews"][image["bufferView"].get<std::size_t>()];
  const auto stored =
      chunks.binary.subspan(view["byteOffset"].get<std::size_t>(), view["byteLength"].get<std::size_t>());
  const auto wall = textured_wall();
  EXPECT_TRUE(std::equal(stored.begin(), stored.end(), wall.texture->jpeg.begin(), wall.texture->jpeg.end()));
  const auto& coordinates = document["accessors"][primitive["attributes"]["TEXCOORD_0"].get<std::size_t>()];
  const auto& positions = document["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()];
  EXPECT_EQ(coordinates["count"], positions["count"]);
  EXPECT_EQ(coordinates["type"], "VEC2");
  EXPECT_FALSE(primitive["attributes"].contains("COLOR_0"));
}

TEST_F(TextureFile, GlbKeepsAPictureOnceForPiecesThatShareIt) {
  const Submesh wall = textured_wall();
  Model model = model_of(keep_triangles(wall, {true, false}));
  model.nodes.push_back(make_node(2, "rest", keep_triangles(wall, {false, true})));
  model.nodes.push_back(make_node(3, "colored", test::grid(2)));
  const auto glb = to_glb(model).value();
  const auto document = nlohmann::json::parse(split_gltf(glb).value().json);
  EXPECT_EQ(document["images"].size(), 1u);
  EXPECT_EQ(document["materials"].size(), 2u);
  const auto imported = round_trip(model, "a.glb");
  ASSERT_EQ(imported.model.nodes.size(), 3u);
  EXPECT_TRUE(imported.model.nodes[0].submesh->texture);
  EXPECT_TRUE(imported.model.nodes[1].submesh->texture);
  EXPECT_FALSE(imported.model.nodes[2].submesh->texture);
  EXPECT_TRUE(imported.model.nodes[2].submesh->has_colors());
}

TEST_F(TextureFile, GlbWithoutTexturesNamesNoPictures) {
  const auto glb = to_glb(model_of(test::grid(2))).value();
  const auto document = nlohmann::json::parse(split_gltf(glb).value().json);
  EXPECT_FALSE(document.contains("images") || document.contains("textures") || document.contains("samplers"));
}

TEST_F(TextureFile, GlbScalesTheProjectionWithTheUnit) {
  ImportOptions options;
  options.unit_m = 2;
  const Submesh wall = textured_wall();
  const auto imported = round_trip(model_of(wall), "a.glb", options);
  ASSERT_EQ(imported.model.nodes.size(), 1u);
  const auto& read = imported.model.nodes[0].submesh->texture;
  ASSERT_TRUE(read);
  for (const auto& p : wall.positions) {
    EXPECT_LT((pixel_of(*read, 2 * p) - pixel_of(*wall.texture, p)).norm(), 0.01f);
  }
}

TEST_F(TextureFile, GlbWithADamagedProjectionOrPictureIsRefused) {
  const auto glb = to_glb(model_of(textured_wall())).value();
  const auto chunks = split_gltf(glb).value();
  const auto good = nlohmann::json::parse(chunks.json);
  const auto imported_with = [&](const auto& damage) {
    auto document = good;
    damage(document);
    const auto bytes = join_glb(document, chunks.binary);
    write("b.glb", std::string{reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    return import_model(path("b.glb"));
  };
  EXPECT_TRUE(imported_with([](auto&) {}));
  const auto projection = [](auto& document) -> auto& {
    return document["materials"][1]["extras"]["meshloop_projection"];
  };
  EXPECT_FALSE(imported_with([&](auto& document) { projection(document).erase(0); }));
  EXPECT_FALSE(imported_with([&](auto& document) { projection(document) = "none"; }));
  EXPECT_FALSE(imported_with([&](auto& document) { projection(document)[2] = -5; }));
  EXPECT_FALSE(imported_with([&](auto& document) { document["images"][0]["bufferView"] = 99; }));
  EXPECT_FALSE(imported_with([&](auto& document) { document["materials"][1].erase("name"); }));
  EXPECT_FALSE(imported_with([&](auto& document) { document["materials"][1]["name"] = "surface"; }));
  EXPECT_FALSE(imported_with([&](auto& document) {
    document["bufferViews"][document["images"][0]["bufferView"].template get<std::size_t>()]["byteLength"] = 1000;
  }));
  // Of another program: the picture is passed over, as it always was.
  const auto foreign = imported_with([](auto& document) { document["materials"][1].erase("extras"); });
  ASSERT_TRUE(foreign) << foreign.error().message;
  EXPECT_FALSE((*foreign)[0].submesh.texture);
}

TEST_F(TextureFile, GlbWithAPictureThatCannotBeSentIsRefused) {
  const auto glb = to_glb(model_of(textured_wall())).value();
  const auto chunks = split_gltf(glb).value();
  auto document = nlohmann::json::parse(chunks.json);
  auto jpeg = textured_wall().texture->jpeg;
  const auto import_with = [&](std::size_t bytes) {
    jpeg.resize(bytes);
    std::vector<std::byte> binary{chunks.binary.begin(), chunks.binary.end()};
    auto& view = document["bufferViews"][document["images"][0]["bufferView"].get<std::size_t>()];
    view["byteOffset"] = binary.size();
    view["byteLength"] = bytes;
    binary.insert(binary.end(), jpeg.begin(), jpeg.end());
    document["buffers"][0]["byteLength"] = binary.size();
    const auto grown = join_glb(document, binary);
    write("b.glb", std::string{reinterpret_cast<const char*>(grown.data()), grown.size()});
    return import_model(path("b.glb"));
  };
  const auto largest = import_with(kMostTextureBytes);
  EXPECT_TRUE(largest) << largest.error().message;
  const auto refused = import_with(kMostTextureBytes + 1);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("make it smaller"), std::string::npos) << refused.error().message;
}

TEST_F(TextureFile, PlyAndObjHaveTheColorsAtTheVertices) {
  const Submesh wall = textured_wall();
  const auto expected = vertex_colors(wall).value();
  for (const char* name : {"a.ply", "a.obj"}) {
    const auto imported = round_trip(model_of(wall), name);
    ASSERT_EQ(imported.model.nodes.size(), 1u) << name;
    const Submesh& read = *imported.model.nodes[0].submesh;
    ASSERT_EQ(read.positions.size(), 4u);
    for (std::size_t i = 0; i < 4; ++i) {
      const auto same = std::find(wall.positions.begin(), wall.positions.end(), read.positions[i]);
      ASSERT_NE(same, wall.positions.end());
      EXPECT_EQ(read.colors[i], expected[static_cast<std::size_t>(same - wall.positions.begin())]) << name;
    }
  }
}

}  // namespace
}  // namespace meshloop
