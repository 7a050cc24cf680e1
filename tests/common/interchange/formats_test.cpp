// Each format as other programs write it: the same surfaces must come out.
#include <bit>
#include <cmath>
#include <cstring>

#include "common/interchange/model_file.h"
#include "common/interchange/ply_reader.h"
#include "common/interchange/read_file.h"
#include "common/interchange/scene_geometry.h"
#include "common/interchange/stl_reader.h"
#include "common/interchange/vrml_reader.h"
#include "common/interchange/x3d_reader.h"
#include "files.h"

namespace meshloop {
namespace {

class Formats : public test::Folder {
 protected:
  Result<std::vector<ImportedPart>> read(const std::string& name, const std::string& content) const {
    return import_model(write(name, content));
  }
  std::string refusal(const std::string& name, const std::string& content) const {
    const auto parts = read(name, content);
    return parts ? std::string{} : parts.error().message;
  }
};

/// The volume inside a closed surface; positive when it is seen from outside.
double volume(const Submesh& mesh) {
  double six = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d p = mesh.positions[a].cast<double>(), q = mesh.positions[b].cast<double>(),
                          r = mesh.positions[c].cast<double>();
    six += p.dot(q.cross(r));
  }
  return six / 6;
}

double area(const Submesh& mesh) {
  double two = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d p = mesh.positions[a].cast<double>();
    two += (mesh.positions[b].cast<double>() - p).cross(mesh.positions[c].cast<double>() - p).norm();
  }
  return two / 2;
}

template <class T>
void append(std::string& bytes, T value, std::endian order) {
  std::array<char, sizeof(T)> raw{};
  std::memcpy(raw.data(), &value, sizeof value);
  if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
  bytes.append(raw.data(), raw.size());
}

std::string binary_ply(std::endian order) {
  std::string ply =
      std::string{"ply\r\nformat "} + (order == std::endian::little ? "binary_little_endian" : "binary_big_endian") +
      " 1.0\r\ncomment made by hand\r\nelement camera 1\r\nproperty list uchar float lens\r\n"
      "element vertex 4\r\nproperty double x\r\nproperty double y\r\nproperty double z\r\n"
      "property float confidence\r\nproperty ushort red\r\nproperty ushort green\r\nproperty ushort blue\r\n"
      "element face 1\r\nproperty uchar flags\r\nproperty list uchar uint vertex_index\r\nend_header\r\n";
  append(ply, std::uint8_t{2}, order);
  append(ply, 1.0f, order);
  append(ply, 2.0f, order);
  const double corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.5}, {0, 1, 0.5}};
  for (const auto& corner : corners) {
    for (const double value : corner) append(ply, value, order);
    append(ply, 0.5f, order);
    for (const auto value : std::initializer_list<std::uint16_t>{65535, 32896, 0}) append(ply, value, order);
  }
  append(ply, std::uint8_t{7}, order);
  append(ply, std::uint8_t{4}, order);
  for (const std::uint32_t index : {0u, 1u, 2u, 3u}) append(ply, index, order);
  return ply;
}

TEST_F(Formats, ReadsBinaryPlyOfBothByteOrdersWithDoublesWideColorsAndForeignProperties) {
  for (const auto order : {std::endian::little, std::endian::big}) {
    const auto parts = read("a.ply", binary_ply(order));
    ASSERT_TRUE(parts) << parts.error().message;
    const Submesh& mesh = (*parts)[0].submesh;
    EXPECT_EQ(mesh.triangles.size(), 2u);
    EXPECT_EQ(mesh.positions.size(), 4u);
    EXPECT_EQ(mesh.colors, (std::vector<Rgb8>(4, Rgb8{255, 128, 0})));
    EXPECT_NEAR(area(mesh), std::sqrt(1.25), 1e-6);
  }
}

TEST_F(Formats, RefusesEveryTruncationOfABinaryPly) {
  const std::string whole = binary_ply(std::endian::little);
  ASSERT_TRUE(parse_ply(whole, [](double) {}));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(parse_ply(whole.substr(0, size), [](double) {})) << size;
  }
}

TEST_F(Formats, ReadsPlyStripsAndFloatColors) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
      "property float red\nproperty float green\nproperty float blue\n";
  const std::string vertices = "0 0 0 1 0.5 0\n1 0 0 1 .5 0\n0 1 0 1 5e-1 0\n1 1 0 1 0.5 0\n0 2 0 1 0.5 0\n";
  const auto strip = read("a.ply", head + "element tristrips 1\nproperty list int int vertex_indices\nend_header\n" +
                                       vertices + "8 0 1 2 3 -1 2 3 4\n");
  ASSERT_TRUE(strip) << strip.error().message;
  const Submesh& mesh = (*strip)[0].submesh;
  ASSERT_EQ(mesh.triangles.size(), 3u);
  EXPECT_EQ(mesh.colors, (std::vector<Rgb8>(5, Rgb8{255, 128, 0})));
  EXPECT_NEAR(area(mesh), 1.5, 1e-6);
  for (const auto& [a, b, c] : mesh.triangles) {
    EXPECT_GT((mesh.positions[b] - mesh.positions[a]).cross(mesh.positions[c] - mesh.positions[a]).z(), 0);
  }
}

TEST_F(Formats, RefusesAPlyThatClaimsMoreThanItHolds) {
  const std::string head = "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n";
  EXPECT_NE(refusal("a.ply", head + "property float y\nproperty float z\nend_header\nabc").find("too short"),
            std::string::npos);
  EXPECT_NE(refusal("b.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty colour x\nend_header\n1\n")
                .find("no PLY: 'property colour x'"),
            std::string::npos);
}

TEST_F(Formats, KeepsTheOutlineOfConcavePolygons) {
  // An arrow head whose first corner sees only a part of it.
  const auto parts =
      read("a.ply",
           "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
           "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
           "0 0 0\n2 -1 0\n0.5 0 0\n2 1 0\n4 0 1 2 3\n");
  ASSERT_TRUE(parts) << parts.error().message;
  EXPECT_EQ((*parts)[0].submesh.triangles.size(), 2u);
  EXPECT_NEAR(area((*parts)[0].submesh), 0.5, 1e-6);
}

TEST_F(Formats, ReadsBinaryStl) {
  const Submesh grid = test::grid(8, 0.0625f, false);
  std::string stl(80, 'x');
  append(stl, static_cast<std::uint32_t>(grid.triangles.size()), std::endian::little);
  for (const auto& triangle : grid.triangles) {
    stl.append(12, '\0');
    for (const auto index : triangle) {
      for (const float value : grid.positions[index]) append(stl, value, std::endian::little);
    }
    stl.append(2, '\0');
  }
  const auto parts = read("a.stl", stl);
  ASSERT_TRUE(parts) << parts.error().message;
  EXPECT_EQ((*parts)[0].submesh.positions.size(), grid.positions.size());
  EXPECT_TRUE(test::faces_of((*parts)[0].submesh) == test::faces_of(grid));
  stl.pop_back();
  EXPECT_FALSE(is_binary_stl(stl));
}

const std::string kVrml = "#VRML V2.0 utf8\n";

TEST_F(Formats, ReadsVrmlSolidsWithTheirSizeFromOutside) {
  struct Solid {
    const char* text;
    double volume;
  };
  for (const auto& [text, expected] :
       {Solid{"Box { size 1 2 3 }", 6.0}, Solid{"Sphere { radius 0.5 }", M_PI / 6},
        Solid{"Cylinder { radius 0.5 height 2 }", M_PI / 2}, Solid{"Cone { bottomRadius 0.5 height 3 }", M_PI / 4}}) {
    const auto parts = read("a.wrl", kVrml + "Shape { geometry " + text + " }");
    ASSERT_TRUE(parts) << parts.error().message;
    const double found = volume((*parts)[0].submesh);
    EXPECT_LE(found, expected * (1 + 1e-6)) << text;
    // The surface lies within the stated deflection.
    EXPECT_GT(found, expected - area((*parts)[0].submesh) * kSolidDeflection) << text;
  }
}

TEST_F(Formats, LeavesOutTheFacesThatAVrmlCylinderDoesNotHave) {
  const auto tube = read("a.wrl", kVrml + "Shape { geometry Cylinder { top FALSE bottom FALSE } }");
  ASSERT_TRUE(tube) << tube.error().message;
  EXPECT_NEAR(area((*tube)[0].submesh), 4 * M_PI, 0.01);
  const auto discs = read("b.wrl", kVrml + "Shape { geometry Cylinder { side FALSE } }");
  ASSERT_TRUE(discs) << discs.error().message;
  EXPECT_NEAR(area((*discs)[0].submesh), 2 * M_PI, 0.01);
}

TEST_F(Formats, AppliesVrmlTransformsAndDefAndUse) {
  const auto parts = read("a.wrl", kVrml + R"(# a comment "with quotes" {
    DEF twice Transform { translation 1 0 0, rotation 0 0 1 1.5707963 scale 2 1 1 center 0 1 0
      children [ DEF box Shape { geometry Box { size 0.2 0.2 0.2 } } ] }
    Transform { translation 0 0 5 children USE box }
    Switch { whichChoice 1 choice [ Shape { geometry Box {} } Transform { scale -1 1 1 children [ USE box ] } ] }
    WorldInfo { title "a { title" info [ "one" "two" ] }
    Script { field SFFloat speed 1.5 eventIn SFBool go url "javascript: x" }
    ROUTE a.b TO c.d)");
  ASSERT_TRUE(parts) << parts.error().message;
  ASSERT_EQ(parts->size(), 3u);
  EXPECT_EQ((*parts)[0].name, "box");
  const auto first = (*parts)[0].submesh.bounds();
  // Scaled along x, turned to y, about (0, 1, 0): (x, y) -> (1 - (y - 1), 1 + 2 x).
  EXPECT_LT((first.min() - Eigen::Vector3f(1.9f, 0.8f, -0.1f)).norm(), 1e-5f);
  EXPECT_LT((first.max() - Eigen::Vector3f(2.1f, 1.2f, 0.1f)).norm(), 1e-5f);
  EXPECT_LT(((*parts)[1].submesh.bounds().center() - Eigen::Vector3f(0, 0, 5)).norm(), 1e-5f);
  // A mirror keeps the outside outside.
  EXPECT_NEAR(volume((*parts)[2].submesh), 0.008, 1e-6);
}

TEST_F(Formats, TakesVrmlFaceAndVertexColors) {
  const std::string faces =
      "Shape { appearance Appearance { material Material { diffuseColor 0 0 1 } } geometry IndexedFaceSet { "
      "coord Coordinate { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0, 0 0 1 ] } coordIndex [ 0 1 2 3 -1 0 1 4 -1 ] ";
  const auto material = read("a.wrl", kVrml + faces + "} }");
  ASSERT_TRUE(material) << material.error().message;
  EXPECT_EQ((*material)[0].submesh.triangles.size(), 3u);
  EXPECT_EQ((*material)[0].submesh.colors, (std::vector<Rgb8>(5, Rgb8{0, 0, 255})));
  const auto by_face = read(
      "b.wrl", kVrml + faces + "color Color { color [ 1 0 0, 0 1 0 ] } colorPerVertex FALSE colorIndex [ 1 0 ] } }");
  ASSERT_TRUE(by_face) << by_face.error().message;
  const auto& colors = (*by_face)[0].submesh.colors;
  EXPECT_EQ(std::count(colors.begin(), colors.end(), Rgb8{0, 255, 0}), 4);
  EXPECT_EQ(std::count(colors.begin(), colors.end(), Rgb8{255, 0, 0}), 3);
}

TEST_F(Formats, RefusesVrmlThatItWouldReadWrongly) {
  EXPECT_NE(refusal("a.wrl", "#VRML V1.0 ascii\nCube {}").find("VRML 1.0"), std::string::npos);
  EXPECT_NE(refusal("b.wrl", kVrml + "Shape { geometry Extrusion { } }").find("Extrusion"), std::string::npos);
  EXPECT_NE(refusal("c.wrl", kVrml + "PROTO Chair [ ] { Group { } }").find("PROTO"), std::string::npos);
  EXPECT_NE(refusal("d.wrl", kVrml + "\n\nShape { geometry Box { size 1 2 3 }").find("line 4"), std::string::npos);
  EXPECT_NE(refusal("e.wrl", kVrml + "Group { children USE x }").find("USE names 'x'"), std::string::npos);
  EXPECT_NE(refusal("f.wrl", kVrml + "Inline { url \"b.wrl\" }").find("Inline"), std::string::npos);
  EXPECT_NE(refusal("g.wrl", kVrml + "Shape { geometry IndexedFaceSet { coord Coordinate { point [ 0 0 0 ] } "
                                     "coordIndex [ 0 1 2 -1 ] } }")
                .find("not there"),
            std::string::npos);
}

TEST_F(Formats, EndsAtVrmlThatGrowsByUse) {
  std::string text = kVrml + "DEF a0 Shape { geometry Box { } }";
  for (int i = 1; i < 100; ++i) {
    text += "DEF a" + std::to_string(i) + " Group { children [ USE a" + std::to_string(i - 1) + " USE a" +
            std::to_string(i - 1) + " ] }";
  }
  EXPECT_NE(refusal("a.wrl", text).find("million times"), std::string::npos);
  std::string deep = kVrml + "DEF a0 Group { }";
  for (int i = 1; i < 1000; ++i) {
    deep += "DEF a" + std::to_string(i) + " Group { children USE a" + std::to_string(i - 1) + " }";
  }
  EXPECT_NE(refusal("b.wrl", deep).find("too deeply"), std::string::npos);
}

const std::string kX3dHead = "<?xml version='1.0' encoding='UTF-8'?>\n<X3D profile='Interchange' version='3.3'>\n";

TEST_F(Formats, ReadsX3dAsTheSameSceneInVrml) {
  const auto x3d = read("a.x3d", kX3dHead + R"(<Scene>
    <Transform translation='1 2 3' rotation='0 1 0 0.5' scale='1 2 1'>
      <Shape DEF='s'><Appearance><Material diffuseColor='1 0.5 0'/></Appearance>
        <IndexedFaceSet coordIndex='0 1 2 3 -1, 0 1 4' solid='false'>
          <Coordinate point='0 0 0, 1 0 0, 1 1 0, 0 1 0, 0 0 1'/></IndexedFaceSet></Shape>
    </Transform>
    <Shape USE='s'/>
    <Shape><Sphere radius='0.25'/></Shape>
    <Shape><IndexedTriangleSet index='0 1 2'><Coordinate point='0 0 0 1 0 0 0 1 0'/>
      <ColorRGBA color='1 0 0 1 0 1 0 1 0 0 1 1'/></IndexedTriangleSet></Shape>
  </Scene></X3D>)");
  ASSERT_TRUE(x3d) << x3d.error().message;
  const auto vrml = read("a.wrl", kVrml + R"(
    Transform { translation 1 2 3 rotation 0 1 0 0.5 scale 1 2 1 children DEF s Shape {
      appearance Appearance { material Material { diffuseColor 1 0.5 0 } }
      geometry IndexedFaceSet { coord Coordinate { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0, 0 0 1 ] } solid FALSE
                                coordIndex [ 0 1 2 3 -1 0 1 4 ] } } }
    USE s
    Shape { geometry Sphere { radius 0.25 } })");
  ASSERT_TRUE(vrml) << vrml.error().message;
  ASSERT_EQ(x3d->size(), 4u);
  ASSERT_EQ(vrml->size(), 3u);
  for (std::size_t i = 0; i < vrml->size(); ++i) {
    EXPECT_EQ(content_hash((*x3d)[i].submesh), content_hash((*vrml)[i].submesh)) << i;
  }
  EXPECT_EQ((*x3d)[3].submesh.colors, (std::vector<Rgb8>{{255, 0, 0}, {0, 255, 0}, {0, 0, 255}}));
}

TEST_F(Formats, TakesTheUnitThatAnX3dStates) {
  const std::string box = "<Scene><Shape><Box size='500 500 500'/></Shape></Scene></X3D>";
  const auto mm = import_as_model(
      write("a.x3d", kX3dHead + "<head><unit category='length' name='mm' conversionFactor='0.001'/></head>" + box));
  ASSERT_TRUE(mm) << mm.error().message;
  EXPECT_EQ(mm->unit.source, LengthUnit::Source::stated);
  EXPECT_FLOAT_EQ(mm->size_m.x(), 0.5f);
}

TEST_F(Formats, RefusesX3dOfWhichAPartWouldBeMissing) {
  const std::string shape = "<Scene><Shape><Appearance/><MetadataString/><Disk2D/></Shape></Scene></X3D>";
  EXPECT_NE(refusal("a.x3d", kX3dHead + shape).find("Disk2D"), std::string::npos);
  const std::string nested = "<Scene><Group><Scene></Scene><Shape><Box/></Shape></Group></Scene></X3D>";
  EXPECT_NE(refusal("b.x3d", kX3dHead + nested).find("Scene"), std::string::npos);
  const auto face = read("c.x3d", kX3dHead +
                                      "<Scene><CADFace><Shape containerField='shape'><Box/></Shape></CADFace>"
                                      "</Scene></X3D>");
  ASSERT_TRUE(face) << face.error().message;
  EXPECT_EQ(face->size(), 1u);
}

TEST_F(Formats, RefusesX3dThatIsNoXmlOrUsesPrototypes) {
  EXPECT_NE(refusal("a.x3d", kX3dHead + "<Scene><Shape></Scene></X3D>").find("line 3"), std::string::npos);
  EXPECT_NE(refusal("b.x3d", kX3dHead + "<Scene><ProtoInstance name='x'/></Scene></X3D>").find("ProtoInstance"),
            std::string::npos);
}

TEST_F(Formats, RefusesASizeThatCannotBeMeantAndNamesTheOption) {
  const auto text = [](const char* size) {
    return std::string{"v 0 0 0\nv "} + size + " 0 0\nv 0 " + size + " 0\nf 1 2 3\n";
  };
  EXPECT_NE(refusal("mm.obj", text("3200")).find("--unit mm"), std::string::npos) << refusal("mm.obj", text("3200"));
  EXPECT_NE(refusal("tiny.obj", text("0.004")).find("--scale"), std::string::npos);
  const auto scaled = import_as_model(write("a.obj", text("3200")), {.unit_m = 0.001});
  ASSERT_TRUE(scaled) << scaled.error().message;
  EXPECT_EQ(scaled->unit.source, LengthUnit::Source::given);
  EXPECT_NEAR(scaled->size_m.x(), 3.2f, 1e-3f);
  const auto meant = import_as_model(write("b.obj", text("1500")), {.unit_m = 1});
  ASSERT_TRUE(meant) << meant.error().message;
  EXPECT_FALSE(import_as_model(write("c.obj", text("1")), {.unit_m = -1}));
}

TEST_F(Formats, ReportsGrowingProgressUpToTheEnd) {
  std::string off =
      "ply\nformat ascii 1.0\nelement vertex 300000\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  for (int i = 0; i < 300000; ++i) off += i % 2 == 0 ? "0 0 1\n" : (i % 3 == 0 ? "1 0 0\n" : "0 1 0\n");
  std::vector<double> shares;
  ImportOptions options;
  options.progress = [&](double share) { shares.push_back(share); };
  const auto parts = import_model(write("a.ply", off + "3 0 1 3\n"), options);
  ASSERT_TRUE(parts) << parts.error().message;
  ASSERT_GE(shares.size(), 1u);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_GT(shares.back(), 0.5);
  EXPECT_LE(shares.back(), 1);
}

}  // namespace
}  // namespace meshloop
