#include "common/implicit/cast_ray.h"
#include "common/interchange/model_file.h"
#include "common/mesh/lattice.h"
#include "files.h"

namespace meshloop {
namespace {

class ShapeImport : public test::Folder {};

TEST_F(ShapeImport, MakesNodesWithAShapeAndTrianglesWithinTheStatedError) {
  const auto imported =
      import_as_model(write("room.yaml",
                            "shapes:\n"
                            "  - name: ball\n    color: [255, 128, 0]\n    solid: {sphere: {radius: 0.5}}\n"
                            "  - name: plate\n    solid: {box: {size: [1, 1, 0.02]}}\n"));
  ASSERT_TRUE(imported) << imported.error().message;
  const Model& model = imported->model;
  ASSERT_EQ(model.nodes.size(), 2u);
  EXPECT_EQ(model.nodes[0].name, "ball");
  EXPECT_EQ(model.nodes[0].submesh->colors.front(), (Rgb8{255, 128, 0}));
  EXPECT_TRUE(is_on_lattice(*model.nodes[0].submesh));
  EXPECT_EQ(imported->unit.source, LengthUnit::Source::stated);
  EXPECT_NEAR(imported->size_m.z(), 1, 2e-3);
  EXPECT_GT(imported->stand_in_error_m, 0);
  EXPECT_LT(imported->stand_in_error_m, 1e-3);
  for (const auto& p : model.nodes[0].submesh->positions) EXPECT_NEAR(p.norm(), 0.5, imported->stand_in_error_m);
  for (const auto& node : model.nodes) {
    ASSERT_TRUE(node.shape);
    EXPECT_LE(node.submesh->triangles.size(), 60'000u);
  }
}

TEST_F(ShapeImport, ANodeWhoseTrianglesAreReplacedIsNoShapeAnyMore) {
  const auto imported = import_as_model(write("a.yaml", "shapes:\n  - {name: a, solid: {sphere: {radius: 0.5}}}\n"));
  ASSERT_TRUE(imported) << imported.error().message;
  const auto submesh = std::make_shared<const Submesh>(test::grid(2));
  const auto moved = apply(imported->model, {MoveNode{1, Pose::Identity()}}, 2);
  ASSERT_TRUE(moved);
  EXPECT_TRUE(moved->nodes[0].shape);
  const auto replaced = apply(imported->model, {ReplaceSubmesh{1, submesh}}, 2);
  ASSERT_TRUE(replaced);
  EXPECT_FALSE(replaced->nodes[0].shape);
}

TEST_F(ShapeImport, RefusesOtherUnitsAndNamesTheFile) {
  const auto file = write("a.yaml", "shapes:\n  - {name: a, solid: {sphere: {radius: 0.5}}}\n");
  EXPECT_FALSE(import_as_model(file, {.unit_m = 0.001}));
  EXPECT_NE(import_as_model(write("b.yaml", "shapes: 3")).error().message.find("b.yaml"), std::string::npos);
  EXPECT_NE(import_as_model(path("none.yaml")).error().message.find("could not be read"), std::string::npos);
}

}  // namespace
}  // namespace meshloop
