#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>
#include <new>
#include <numeric>

#include "common/interchange/isolated_import.h"
#include "common/interchange/model_file.h"
#include "common/interchange/split.h"
#include "common/interchange/weld.h"
#include "common/interchange/writers.h"
#include "common/mesh/lattice.h"
#include "files.h"
#include "sanitized.h"

namespace meshloop {
namespace {

class Import : public test::Folder {
 protected:
  std::string refusal(const std::filesystem::path& file) const {
    const auto parts = import_model(file);
    return parts ? std::string{} : parts.error().message;
  }
};

const std::string kObjTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

TEST_F(Import, TriangulatesPolygonsAndJoinsVertices) {
  const auto parts = import_model(write("a.obj",
                                        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 2 0\nv 1 2 0\n"
                                        "f 1 2 3 4\nf 4 3 6 5\n"));
  ASSERT_TRUE(parts) << parts.error().message;
  ASSERT_EQ(parts->size(), 1u);
  EXPECT_EQ((*parts)[0].submesh.triangles.size(), 4u);
  EXPECT_EQ((*parts)[0].submesh.positions.size(), 6u);
  EXPECT_FALSE((*parts)[0].submesh.has_colors());
}

TEST_F(Import, KeepsObjVertexColors) {
  const auto parts = import_model(write("a.obj", "v 0 0 0 1 0 0\nv 1 0 0 0 0.5 0\nv 0 1 0 0 0 1\nf 1 2 3\n"));
  ASSERT_TRUE(parts) << parts.error().message;
  EXPECT_EQ((*parts)[0].submesh.colors, (std::vector<Rgb8>{{255, 0, 0}, {0, 128, 0}, {0, 0, 255}}));
}

TEST_F(Import, TakesTheColorThatAMaterialNames) {
  write("a.mtl", "newmtl red\nKd 1 0.5 0\n");
  const auto parts = import_model(write("a.obj", "mtllib a.mtl\nusemtl red\n" + kObjTriangle));
  ASSERT_TRUE(parts) << parts.error().message;
  EXPECT_EQ((*parts)[0].submesh.colors, (std::vector<Rgb8>(3, Rgb8{255, 128, 0})));
}

TEST_F(Import, ReadsAsciiPlyAndOffAndStl) {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n0 0 0 1 2 3\n1 0 0 4 5 6\n0 1 0 7 8 9\n3 0 1 2\n";
  const auto from_ply = import_model(write("a.ply", ply));
  ASSERT_TRUE(from_ply) << from_ply.error().message;
  EXPECT_EQ((*from_ply)[0].submesh.colors, (std::vector<Rgb8>{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}));
  const auto from_off = import_model(write("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
  ASSERT_TRUE(from_off) << from_off.error().message;
  EXPECT_EQ((*from_off)[0].submesh.triangles.size(), 1u);
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
      "facet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\n";
  const auto from_stl = import_model(write("a.stl", "solid s\n" + facet + "endsolid s\n"));
  ASSERT_TRUE(from_stl) << from_stl.error().message;
  EXPECT_EQ((*from_stl)[0].submesh.triangles.size(), 2u);
  EXPECT_EQ((*from_stl)[0].submesh.positions.size(), 4u);
  EXPECT_FALSE((*from_stl)[0].submesh.has_colors());
}

TEST_F(Import, NamesPartsWithoutANameAfterTheFile) {
  const auto parts = import_model(write("chair.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
  ASSERT_TRUE(parts) << parts.error().message;
  EXPECT_EQ((*parts)[0].name, "chair");
}

TEST_F(Import, RefusesWhatIsNotAModelWithOneSentence) {
  EXPECT_NE(refusal(path("none.obj")).find("does not exist"), std::string::npos);
  EXPECT_NE(refusal(folder_).find("folder"), std::string::npos);
  EXPECT_NE(refusal(write("a.txt", kObjTriangle)).find("unknown ending"), std::string::npos);
  EXPECT_NE(refusal(write("empty.obj", "")).find("could not be read"), std::string::npos);
  EXPECT_NE(refusal(write("words.glb", "nothing of use")).find("could not be read"), std::string::npos);
  EXPECT_NE(refusal("/dev/null").find("not a regular file"), std::string::npos);
  EXPECT_NE(refusal(write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\np 1 2 3\n")).find("no triangles"),
            std::string::npos);
}

TEST_F(Import, RefusesIndicesOutOfRange) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_NE(refusal(write("a.ply", head + "3 0 1 99\n")).find("could not be read"), std::string::npos);
  EXPECT_NE(refusal(write("b.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 99\n")).find("could not be read"),
            std::string::npos);
}

TEST_F(Import, RefusesIndicesOutOfRangeInAGlb) {
  Model model;
  model.nodes.push_back(make_node(1, "wall", test::grid(2)));
  auto bytes = to_glb(model).value();
  bytes.back() = std::byte{0x7f};  // the highest byte of the last index
  write("a.glb", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  EXPECT_NE(refusal(path("a.glb")).find("could not be read"), std::string::npos) << refusal(path("a.glb"));
}

TEST_F(Import, RefusesPositionsThatAreNotFiniteOrFarAway) {
  EXPECT_NE(refusal(write("nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")).find("could not be read"),
            std::string::npos);
  EXPECT_NE(refusal(write("far.obj", "v 1e9 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")).find("metres"), std::string::npos);
}

TEST_F(Import, RefusesATruncatedGlb) {
  ASSERT_TRUE(export_model(test::two_nodes(), path("a.glb")));
  const auto size = std::filesystem::file_size(path("a.glb"));
  for (std::uintmax_t cut = 0; cut < size; cut += size / 12) {
    std::filesystem::copy_file(path("a.glb"), path("b.glb"), std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(path("b.glb"), cut);
    EXPECT_NE(refusal(path("b.glb")).find("could not be read"), std::string::npos) << cut << " of " << size;
  }
}

TEST_F(Import, ACrashOfTheReaderIsAnError) {
  const auto crash = [](const Progress&) -> Result<ReadParts> {
    std::raise(SIGSEGV);
    return fail("never");
  };
  const auto parts = run_isolated("x.ply", {.max_seconds = 5}, crash);
  ASSERT_FALSE(parts);
  EXPECT_EQ(parts.error().message, "'x.ply' could not be read: the importer crashed; the file is probably damaged");
}

TEST_F(Import, TooLittleMemoryIsSaidToBeThat) {
  const auto message = [](const std::function<Result<ReadParts>(const Progress&)>& reader) {
    return run_isolated("x.ply", {.max_seconds = 5}, reader).error().message;
  };
  const std::string expected = "'x.ply' could not be read: it needs more than 4 GiB of memory";
  EXPECT_EQ(message([](const Progress&) -> Result<ReadParts> { throw std::bad_alloc{}; }), expected);
  EXPECT_EQ(message([](const Progress&) -> Result<ReadParts> { return fail("std::bad_alloc"); }), expected);
}

TEST_F(Import, ACrashUnderALimitOfMemoryDoesNotAccuseTheFileAlone) {
  if (test::kSanitized) GTEST_SKIP() << "sanitizers reserve more addresses than any limit allows";
  const pid_t child = ::fork();
  if (child == 0) {
    const rlimit limit{rlim_t{3} << 30, rlim_t{3} << 30};
    ::setrlimit(RLIMIT_AS, &limit);
    const auto crash = [](const Progress&) -> Result<ReadParts> {
      std::raise(SIGSEGV);
      return fail("never");
    };
    const auto parts = run_isolated("x.ply", {.max_seconds = 5}, crash);
    ::_exit(!parts && parts.error().message.find("3072 MiB of memory") != std::string::npos ? 0 : 1);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
}

TEST_F(Import, AnEndlessReaderIsStopped) {
  const auto loop = [](const Progress&) -> Result<ReadParts> {
    for (volatile unsigned i = 0;;) i = i + 1;
  };
  const auto parts = run_isolated("x.ply", {.max_seconds = 1}, loop);
  ASSERT_FALSE(parts);
  EXPECT_NE(parts.error().message.find("stopped after 1 s"), std::string::npos) << parts.error().message;
}

TEST_F(Import, AReaderThatThrowsIsAnError) {
  const auto throws = [](const Progress&) -> Result<ReadParts> { throw std::runtime_error("two\nlines"); };
  EXPECT_EQ(run_isolated("x.ply", {.max_seconds = 5}, throws).error().message, "'x.ply' could not be read: two lines");
}

TEST_F(Import, SplitsLargePartsAndLosesNothing) {
  Model model;
  model.nodes.push_back(make_node(1, "wall", test::grid(40)));
  ASSERT_TRUE(export_model(model, path("a.glb")));
  const auto parts = import_model(path("a.glb"), {.max_triangles_per_part = 500});
  ASSERT_TRUE(parts) << parts.error().message;
  EXPECT_EQ(parts->size(), 8u);
  std::vector<test::Face> faces;
  for (const auto& part : *parts) {
    EXPECT_LE(part.submesh.triangles.size(), 500u);
    const auto some = test::faces_of(part.submesh);
    faces.insert(faces.end(), some.begin(), some.end());
  }
  std::sort(faces.begin(), faces.end());
  EXPECT_TRUE(faces == test::faces_of(test::grid(40)));
  EXPECT_EQ((*parts)[7].name, "wall.8");
}

TEST_F(Import, MakesAModelOnTheLattice) {
  const auto model = import_as_model(write("a.obj",
                                           "o one\nv 0.1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
                                           "o dust\nv 0 0 0\nv 0.00001 0 0\nv 0 0.00001 0\nf 4 5 6\n"
                                           "o two\nv 0 0 3.3\nv 1 0 3\nv 0 1 3\nf 7 8 9\n"));
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_EQ(model->model.revision, 1u);
  ASSERT_EQ(model->model.nodes.size(), 2u);
  EXPECT_EQ(model->model.nodes[0].name, "one");
  EXPECT_EQ(model->model.nodes[1].name, "two");
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(model->model.nodes[i].id, i + 1);
    EXPECT_TRUE(is_on_lattice(*model->model.nodes[i].submesh));
    EXPECT_EQ(model->model.nodes[i].hash, content_hash(*model->model.nodes[i].submesh));
  }
}

TEST_F(Import, RefusesAModelInOtherUnits) {
  const auto wide = import_as_model(write("mm.obj", "v 0 0 0\nv 3000 0 0\nv 0 1000 0\nf 1 2 3\n"));
  ASSERT_FALSE(wide);
  EXPECT_NE(wide.error().message.find("metres"), std::string::npos) << wide.error().message;
  const auto tiny = import_as_model(write("km.obj", "v 0 0 0\nv 0.00003 0 0\nv 0 0.00001 0\nf 1 2 3\n"));
  ASSERT_FALSE(tiny);
  EXPECT_NE(tiny.error().message.find("metres"), std::string::npos) << tiny.error().message;
}

TEST(Weld, JoinsEqualVerticesAndKeepsDifferentColorsApart) {
  Submesh soup;
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {-0.0f, 1, 0}};
  soup.triangles = {{0, 1, 2}, {3, 4, 5}};
  EXPECT_EQ(welded(soup).positions.size(), 4u);
  soup.colors = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {2, 2, 2}, {1, 1, 1}, {1, 1, 1}};
  const auto joined = welded(soup);
  EXPECT_EQ(joined.positions.size(), 5u);
  EXPECT_EQ(test::faces_of(joined), test::faces_of(soup));
}

TEST(Split, LeavesWhatHangsTogetherWhole) {
  Submesh both = test::grid(40, 0.0625F, false);  // a thing stands in the middle of a table of twice as many triangles
  const std::size_t of_table = both.triangles.size();
  const Submesh thing = test::grid(20, 0.0625F, false);
  const auto first = static_cast<std::uint32_t>(both.positions.size());
  for (const auto& p : thing.positions) both.positions.emplace_back(p + Eigen::Vector3f{0.25F, 0.25F, 0.5F});
  for (const auto& [a, b, c] : thing.triangles) both.triangles.push_back({first + a, first + b, first + c});
  const auto pieces = split(both, of_table / 2);
  ASSERT_EQ(pieces.size(), 3U);
  EXPECT_EQ(test::faces_of(pieces[0]).size(), thing.triangles.size());
  EXPECT_GE(pieces[0].bounds().min().z(), 0.5F);
  EXPECT_EQ(pieces[1].triangles.size() + pieces[2].triangles.size(), of_table);
  EXPECT_LT(pieces[1].bounds().max().z(), 0.5F);
}

TEST(Split, CutsStackedTrianglesToo) {
  Submesh stacked = test::grid(1);
  for (int i = 0; i < 6; ++i) stacked.triangles.push_back(stacked.triangles[0]);
  std::size_t count = 0;
  for (const auto& piece : split(stacked, 1)) {
    EXPECT_EQ(piece.triangles.size(), 1u);
    ++count;
  }
  EXPECT_EQ(count, 8u);
}

}  // namespace
}  // namespace meshloop
