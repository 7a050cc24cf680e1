#include <sys/resource.h>
#include <sys/wait.h>

#include <cmath>

#include "common/interchange/color_space.h"
#include "common/interchange/json_text.h"
#include "common/interchange/model_file.h"
#include "common/interchange/writers.h"
#include "files.h"

namespace meshloop {
namespace {

class Export : public test::Folder {};

Submesh in_world(const Node& node) {
  Submesh moved = *node.submesh;
  for (auto& p : moved.positions) p = (node.T_world_node * p.cast<double>()).cast<float>();
  return moved;
}

TEST_F(Export, GlbBringsNodesBackExactly) {
  const Model model = test::two_nodes();
  const auto written = export_model(model, path("a.glb"));
  ASSERT_TRUE(written) << written.error().message;
  const auto parts = import_model(path("a.glb"));
  ASSERT_TRUE(parts) << parts.error().message;
  ASSERT_EQ(parts->size(), 2u);
  EXPECT_EQ((*parts)[0].name, "wall");
  EXPECT_EQ((*parts)[1].name, "b\"ox\\ \xc3\xa4\n?");
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_TRUE((*parts)[i].submesh.has_colors());
    EXPECT_TRUE(test::faces_of((*parts)[i].submesh) == test::faces_of(in_world(model.nodes[i]))) << i;
  }
}

TEST_F(Export, GlbAppliesGeneralTransformsWithinAMicrometre) {
  Model model;
  const Pose T_world_node = make_pose({1, 2, 3}, Eigen::Quaterniond{Eigen::AngleAxisd{0.7, Eigen::Vector3d::UnitY()}});
  model.nodes.push_back(make_node(1, "turned", test::grid(4), T_world_node));
  ASSERT_TRUE(export_model(model, path("a.glb")));
  const auto parts = import_model(path("a.glb"));
  ASSERT_TRUE(parts) << parts.error().message;
  const Submesh expected = in_world(model.nodes[0]);
  ASSERT_EQ((*parts)[0].submesh.triangles.size(), expected.triangles.size());
  for (std::size_t t = 0; t < expected.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& p = (*parts)[0].submesh.positions[(*parts)[0].submesh.triangles[t][k]];
      EXPECT_LT((p - expected.positions[expected.triangles[t][k]]).norm(), 1e-6f);
    }
  }
}

TEST_F(Export, PlyAndObjBringTheWorldBackExactly) {
  const Model model = test::two_nodes();
  Submesh all;
  std::vector<test::Face> expected;
  for (const auto& node : model.nodes) {
    const auto faces = test::faces_of(in_world(node));
    expected.insert(expected.end(), faces.begin(), faces.end());
  }
  std::sort(expected.begin(), expected.end());
  for (const char* name : {"a.ply", "a.obj"}) {
    const auto written = export_model(model, path(name));
    ASSERT_TRUE(written) << written.error().message;
    const auto parts = import_model(path(name));
    ASSERT_TRUE(parts) << parts.error().message;
    std::vector<test::Face> faces;
    for (const auto& part : *parts) {
      EXPECT_TRUE(part.submesh.has_colors()) << name;
      const auto some = test::faces_of(part.submesh);
      faces.insert(faces.end(), some.begin(), some.end());
    }
    std::sort(faces.begin(), faces.end());
    EXPECT_TRUE(faces == expected) << name;
  }
}

TEST_F(Export, NodesWithoutColorsStayWithoutColors) {
  Model model;
  model.nodes.push_back(make_node(1, "plain", test::grid(2, 0.5f, false)));
  for (const char* name : {"a.glb", "a.ply", "a.obj"}) {
    ASSERT_TRUE(export_model(model, path(name)));
    const auto parts = import_model(path(name));
    ASSERT_TRUE(parts) << parts.error().message;
    EXPECT_FALSE((*parts)[0].submesh.has_colors()) << name;
    EXPECT_EQ((*parts)[0].submesh.triangles.size(), 8u) << name;
  }
}

TEST_F(Export, PlyGivesGreyWhereOnlyOtherNodesHaveColors) {
  Model model;
  model.nodes.push_back(make_node(1, "plain", test::grid(1, 0.5f, false)));
  model.nodes.push_back(make_node(2, "colored", test::grid(1, 0.25f)));
  ASSERT_TRUE(export_model(model, path("a.ply")));
  const auto parts = import_model(path("a.ply"));
  ASSERT_TRUE(parts) << parts.error().message;
  const auto& colors = (*parts)[0].submesh.colors;
  EXPECT_EQ(std::count(colors.begin(), colors.end(), kNoColor), 4);
}

TEST_F(Export, LeavesNothingButTheFileAndReplacesAnOldOne) {
  write("a.ply", "old");
  ASSERT_TRUE(export_model(test::two_nodes(), path("a.ply")));
  EXPECT_EQ(entries(), std::vector<std::string>{"a.ply"});
  EXPECT_GT(std::filesystem::file_size(path("a.ply")), 1000u);
}

TEST_F(Export, RefusesWhatCannotBeWrittenWithOneSentence) {
  const Model model = test::two_nodes();
  EXPECT_NE(export_model(model, path("a.fbx")).error().message.find("unknown ending"), std::string::npos);
  EXPECT_NE(export_model(model, path("no/a.glb")).error().message.find("No such file"), std::string::npos);
  std::filesystem::create_directories(path("folder.glb"));
  EXPECT_NE(export_model(model, path("folder.glb")).error().message.find("directory"), std::string::npos);
  EXPECT_NE(export_model(Model{}, path("b.glb")).error().message.find("no nodes"), std::string::npos);
  EXPECT_EQ(entries(), std::vector<std::string>{"folder.glb"});
}

TEST_F(Export, AFullDiskKeepsTheOldFile) {
  write("a.ply", "old");
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1000, 1000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    ::_exit(export_model(test::two_nodes(), path("a.ply")) ? 1 : 0);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0) << "the export was reported as done";
  EXPECT_EQ(entries(), std::vector<std::string>{"a.ply"});
  EXPECT_EQ(std::filesystem::file_size(path("a.ply")), 3u);
}

TEST(ColorSpace, SrgbBytesSurviveLinearSixteenBits) {
  for (int i = 0; i < 256; ++i) {
    const auto byte = static_cast<std::uint8_t>(i);
    const float stored = static_cast<float>(std::lround(65535 * linear_from_srgb(byte))) / 65535;
    EXPECT_EQ(srgb_from_linear(stored), byte);
  }
  EXPECT_NEAR(linear_from_srgb(128), 0.2159f, 1e-4f);
  EXPECT_EQ(srgb_from_linear(std::nanf("")), 0);
}

TEST(JsonString, EscapesWhatJsonCannotHoldAndReplacesWhatIsNotUtf8) {
  EXPECT_EQ(json_string("a\"b\\c"), R"("a\"b\\c")");
  EXPECT_EQ(json_string("\n\t\x01"), R"("\u000a\u0009\u0001")");
  EXPECT_EQ(json_string("\xc3\xa4\xe2\x82\xac\xf0\x9f\x98\x80"), "\"\xc3\xa4\xe2\x82\xac\xf0\x9f\x98\x80\"");
  EXPECT_EQ(json_string("\xc3"), "\"?\"");
  EXPECT_EQ(json_string("\xc0\x80"), "\"??\"");
  EXPECT_EQ(json_string("\xed\xa0\x80"), "\"???\"");
}

}  // namespace
}  // namespace meshloop
