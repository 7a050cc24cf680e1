#include "common/interchange/scene_reader.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/DefaultLogger.hpp>
#include <assimp/Importer.hpp>
#include <assimp/LogStream.hpp>
#include <assimp/ProgressHandler.hpp>
#include <cmath>
#include <optional>
#include <string_view>

#include "common/interchange/color_space.h"
#include "common/interchange/file_ending.h"

namespace meshloop {
namespace {

struct FileTraits {
  std::string stem;
  /// glTF states colours as linear light, the other formats as sRGB.
  bool linear_colors = false;
  /// The format has materials, so that one that is there was named by the file.
  bool has_materials = false;
  /// The colour of a material that the file mentions without one: white in glTF, assimp's grey in OBJ.
  Rgb8 unnamed_color;
  GltfTextures textures = {};
};

FileTraits traits_of(const std::filesystem::path& file) {
  const std::string ending = lower_case_ending(file);
  const bool gltf = ending == ".gltf" || ending == ".glb";
  return {file.stem().string(), gltf, gltf || ending == ".obj", gltf ? Rgb8{255, 255, 255} : Rgb8{153, 153, 153}, {}};
}

Rgb8 to_rgb8(const aiColor4D& color, bool linear) {
  const auto channel = [linear](float value) { return linear ? srgb_from_linear(value) : to_byte(value); };
  return {channel(color.r), channel(color.g), channel(color.b)};
}

/// The colour that the file's material names.
std::optional<Rgb8> material_color(const aiScene& scene, const aiMesh& mesh, const FileTraits& traits) {
  if (!traits.has_materials || mesh.mMaterialIndex >= scene.mNumMaterials) return std::nullopt;
  const aiMaterial& material = *scene.mMaterials[mesh.mMaterialIndex];
  if (material.GetName() == aiString(AI_DEFAULT_MATERIAL_NAME)) return std::nullopt;
  aiColor4D color;
  if (material.Get(AI_MATKEY_BASE_COLOR, color) != aiReturn_SUCCESS &&
      material.Get(AI_MATKEY_COLOR_DIFFUSE, color) != aiReturn_SUCCESS) {
    return std::nullopt;
  }
  const Rgb8 rgb = to_rgb8(color, traits.linear_colors);
  return rgb == traits.unnamed_color ? std::nullopt : std::optional{rgb};
}

std::string part_name(const aiNode& node, const aiMesh& mesh, const FileTraits& traits) {
  const auto usable = [](const aiString& name) { return name.length > 0 && name.C_Str()[0] != '<'; };
  if (node.mNumMeshes > 1 && usable(mesh.mName)) return mesh.mName.C_Str();
  // assimp names the root of formats without nodes after the format, or after the file.
  if (node.mParent != nullptr && usable(node.mName)) return node.mName.C_Str();
  return usable(mesh.mName) ? mesh.mName.C_Str() : traits.stem;
}

Submesh to_submesh(const aiScene& scene, const aiMesh& mesh, const aiMatrix4x4& T_world_node,
                   const FileTraits& traits) {
  Submesh submesh;
  submesh.positions.reserve(mesh.mNumVertices);
  submesh.triangles.reserve(mesh.mNumFaces);
  const auto base = material_color(scene, mesh, traits);
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    const aiVector3D p = T_world_node * mesh.mVertices[i];
    submesh.positions.emplace_back(p.x, p.y, p.z);
    if (mesh.HasVertexColors(0)) {
      submesh.colors.push_back(to_rgb8(mesh.mColors[0][i], traits.linear_colors));
    } else if (base) {
      submesh.colors.push_back(*base);
    }
  }
  const bool mirrored = T_world_node.Determinant() < 0;
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    if (face.mNumIndices != 3) continue;
    submesh.triangles.push_back({face.mIndices[0], face.mIndices[mirrored ? 2 : 1], face.mIndices[mirrored ? 1 : 2]});
  }
  return submesh;
}

/// The texture as it lies on a mesh that has been carried to the world; null when it has none.
std::shared_ptr<const ProjectedTexture> texture_of(const aiScene& scene, const aiMesh& mesh,
                                                   const aiMatrix4x4& T_world_node, const FileTraits& traits) {
  if (traits.textures.empty() || mesh.mMaterialIndex >= scene.mNumMaterials) return nullptr;
  const auto found = traits.textures.find(scene.mMaterials[mesh.mMaterialIndex]->GetName().C_Str());
  if (found == traits.textures.end()) return nullptr;
  const aiMatrix4x4& m = T_world_node;
  Eigen::Matrix4d matrix;
  matrix << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2, m.d3, m.d4;
  auto carried = std::make_shared<ProjectedTexture>(*found->second);
  carried->projection = (carried->projection.cast<double>() * matrix.inverse()).cast<float>();
  return carried;
}

struct Visit {
  const aiNode* node;
  aiMatrix4x4 T_world_node;
};

void add_parts(const aiScene& scene, const Visit& visit, const FileTraits& traits, std::vector<ImportedPart>& parts) {
  for (unsigned m = 0; m < visit.node->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[visit.node->mMeshes[m]];
    ImportedPart part{part_name(*visit.node, mesh, traits), to_submesh(scene, mesh, visit.T_world_node, traits)};
    if (part.submesh.triangles.empty()) continue;
    part.submesh.texture = texture_of(scene, mesh, visit.T_world_node, traits);
    if (part.submesh.texture) part.submesh.colors.clear();
    parts.push_back(std::move(part));
  }
}

std::vector<ImportedPart> collect(const aiScene& scene, const FileTraits& traits) {
  std::vector<ImportedPart> parts;
  std::vector<Visit> open{{scene.mRootNode, scene.mRootNode->mTransformation}};
  while (!open.empty()) {
    const Visit visit = open.back();
    open.pop_back();
    add_parts(scene, visit, traits, parts);
    for (unsigned c = visit.node->mNumChildren; c > 0; --c) {
      const aiNode* child = visit.node->mChildren[c - 1];
      open.push_back({child, visit.T_world_node * child->mTransformation});
    }
  }
  return parts;
}

/// Some of assimp's readers drop a triangle with an index that is out of range, or take another index, and only mention
/// it in the log.
class IndexComplaints : public Assimp::LogStream {
 public:
  explicit IndexComplaints(std::string& first) : first_{first} {}
  void write(const char* message) override {
    const std::string_view text{message};
    const bool complains =
        text.find("out of range") != std::string_view::npos || text.find("out-of-range") != std::string_view::npos;
    if (complains && first_.empty()) first_ = text;
  }

 private:
  std::string& first_;
};

/// The logger is assimp's global; it owns the stream and is destroyed with this.
class AssimpLog {
 public:
  AssimpLog() {
    Assimp::DefaultLogger::create(nullptr, Assimp::Logger::NORMAL, 0);
    Assimp::DefaultLogger::get()->attachStream(new IndexComplaints{complaint_},
                                               Assimp::Logger::Err | Assimp::Logger::Warn);
  }
  ~AssimpLog() { Assimp::DefaultLogger::kill(); }
  AssimpLog(const AssimpLog&) = delete;
  AssimpLog& operator=(const AssimpLog&) = delete;
  [[nodiscard]] const std::string& complaint() const { return complaint_; }

 private:
  std::string complaint_;
};

/// assimp's messages for what happens most, in the words of this program.
std::string plain_words(const std::string& message) {
  if (message.find("No meshes remaining") != std::string::npos) return "it holds no triangles";
  if (message.find("No suitable reader") != std::string::npos) return "its content is not what its ending says";
  return message;
}

/// assimp counts the reading as the first half.
class Reporter : public Assimp::ProgressHandler {
 public:
  explicit Reporter(const Progress& progress) : progress_{progress} {}
  bool Update(float share) override {
    if (share >= 0 && share <= 1) progress_(static_cast<double>(share));
    return true;
  }

 private:
  const Progress& progress_;
};

constexpr unsigned kSteps = aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_RemoveComponent;

template <class Read>
Result<ReadParts> read_scene(const FileTraits& traits, const Progress& progress, Read read) {
  const AssimpLog log;
  Assimp::Importer importer;
  importer.SetProgressHandler(new Reporter{progress});
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  // Only what ends in a submesh is kept, so that the rest costs nothing.
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS, aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS |
                                                          aiComponent_TEXCOORDS | aiComponent_BONEWEIGHTS |
                                                          aiComponent_ANIMATIONS | aiComponent_TEXTURES |
                                                          aiComponent_LIGHTS | aiComponent_CAMERAS);
  const aiScene* scene = read(importer);
  if (scene == nullptr) return fail(plain_words(importer.GetErrorString()));
  if (!log.complaint().empty()) return fail("a triangle names a vertex that is not there");
  if (scene->mRootNode == nullptr || !scene->HasMeshes()) return fail("it holds no triangles");
  return ReadParts{collect(*scene, traits), {}};
}

}  // namespace

Result<ReadParts> read_with_assimp(const std::filesystem::path& file, const Progress& progress) {
  return read_scene(traits_of(file), progress,
                    [&file](Assimp::Importer& importer) { return importer.ReadFile(file.string(), kSteps); });
}

Result<ReadParts> read_glb_with_assimp(std::span<const std::byte> glb, const std::filesystem::path& file,
                                       const GltfTextures& textures, const Progress& progress) {
  auto traits = traits_of(file);
  traits.textures = textures;
  return read_scene(traits, progress, [glb](Assimp::Importer& importer) {
    return importer.ReadFileFromMemory(glb.data(), glb.size(), kSteps, "glb");
  });
}

}  // namespace meshloop
