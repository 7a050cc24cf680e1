// STEP, in builds with -DMESHLOOP_STEP=ON. OpenCASCADE writes what it then reads: what is tested is the unit, the
// deflection, the orientation and the parts.
#ifdef MESHLOOP_STEP
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <Interface_Static.hxx>
#include <STEPControl_Writer.hxx>
#include <gp_Pnt.hxx>

#include "common/interchange/model_file.h"
#include "files.h"

namespace meshloop {
namespace {

class Step : public test::Folder {};

TEST_F(Step, TessellatesSolidsInMetresWithinADeflectionOf2e4) {
  STEPControl_Writer writer;
  Interface_Static::SetCVal("write.step.unit", "INCH");
  // The writer takes the numbers for inches then.
  constexpr double kInch = 1 / 0.0254;
  writer.Transfer(BRepPrimAPI_MakeSphere(gp_Pnt(kInch, 0, 0), 0.5 * kInch).Solid(), STEPControl_AsIs);
  writer.Transfer(BRepPrimAPI_MakeBox(gp_Pnt(0, 0, 0), 0.1 * kInch, 0.2 * kInch, 0.3 * kInch).Solid(),
                  STEPControl_AsIs);
  ASSERT_EQ(writer.Write(path("a.step").c_str()), IFSelect_RetDone);
  const auto parts = import_model(path("a.step"));
  ASSERT_TRUE(parts) << parts.error().message;
  ASSERT_EQ(parts->size(), 2u);
  const Submesh& sphere = (*parts)[0].submesh;
  const Eigen::Vector3f centre{1, 0, 0};
  for (const auto& [a, b, c] : sphere.triangles) {
    const Eigen::Vector3f middle = (sphere.positions[a] + sphere.positions[b] + sphere.positions[c]) / 3;
    EXPECT_NEAR((middle - centre).norm(), 0.5f, 2.0e-4f);
    const Eigen::Vector3f normal =
        (sphere.positions[b] - sphere.positions[a]).cross(sphere.positions[c] - sphere.positions[a]);
    EXPECT_GE(normal.dot(middle - centre), 0);
  }
  EXPECT_GT(sphere.triangles.size(), 1000u);
  const Submesh& box = (*parts)[1].submesh;
  EXPECT_EQ(box.triangles.size(), 12u);
  EXPECT_LT((box.bounds().sizes() - Eigen::Vector3f(0.1f, 0.2f, 0.3f)).norm(), 1e-6f);
  const auto model = import_as_model(path("a.step"));
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_EQ(model->unit.source, LengthUnit::Source::stated);
}

TEST_F(Step, RefusesWhatIsNoStep) {
  const auto parts = import_model(write("a.stp", "ISO-10303-21;\nnothing"));
  ASSERT_FALSE(parts);
  EXPECT_NE(parts.error().message.find("could not be read"), std::string::npos);
}

}  // namespace
}  // namespace meshloop
#endif
