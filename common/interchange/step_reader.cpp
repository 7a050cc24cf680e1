#include "common/interchange/step_reader.h"

#ifdef MESHLOOP_STEP
#include <fmt/format.h>

#include <BRepMesh_IncrementalMesh.hxx>
#include <BRep_Tool.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Poly_Triangulation.hxx>
#include <STEPControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <TopExp_Explorer.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>

namespace meshloop {
namespace {

/// OpenCASCADE converts what the file states to millimetres.
constexpr double kMetresPerUnit = 0.001;

/// What it is asked for holds along edges; where a surface bends in two directions it may be off by nearly twice that.
constexpr double kAskedDeflection = kStepDeflection_m / kMetresPerUnit / 2;

void append_face(const TopoDS_Face& face, Submesh& mesh) {
  TopLoc_Location location;
  const auto triangulation = BRep_Tool::Triangulation(face, location);
  if (triangulation.IsNull()) return;
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (int i = 1; i <= triangulation->NbNodes(); ++i) {
    const gp_Pnt p = triangulation->Node(i).Transformed(location.Transformation());
    mesh.positions.emplace_back(Eigen::Vector3d{p.X(), p.Y(), p.Z()}.cast<float>());
  }
  const bool mirrored = location.Transformation().IsNegative();
  const bool flip = (face.Orientation() == TopAbs_REVERSED) != mirrored;
  for (int t = 1; t <= triangulation->NbTriangles(); ++t) {
    int a = 0, b = 0, c = 0;
    triangulation->Triangle(t).Get(a, b, c);
    if (flip) std::swap(b, c);
    const auto index = [first](int node) { return first + static_cast<std::uint32_t>(node - 1); };
    mesh.triangles.push_back({index(a), index(b), index(c)});
  }
}

Submesh faces_of(const TopoDS_Shape& shape) {
  Submesh mesh;
  for (TopExp_Explorer faces{shape, TopAbs_FACE}; faces.More(); faces.Next()) {
    append_face(TopoDS::Face(faces.Current()), mesh);
  }
  return mesh;
}

void add_part(const TopoDS_Shape& shape, const std::string& name, ReadParts& read) {
  auto mesh = faces_of(shape);
  if (mesh.triangles.empty()) return;
  read.parts.push_back({fmt::format("{}.{}", name, read.parts.size() + 1), std::move(mesh)});
}

Result<ReadParts> tessellate(const std::filesystem::path& file, const Progress& progress) {
  // Its talk would stand between this program's messages.
  Message::DefaultMessenger()->ChangePrinters().Clear();
  STEPControl_Reader reader;
  if (reader.ReadFile(file.c_str()) != IFSelect_RetDone) return fail("it is no STEP file that OpenCASCADE can read");
  progress(0.3);
  if (reader.TransferRoots() == 0) return fail("it holds no shape");
  const TopoDS_Shape shape = reader.OneShape();
  progress(0.5);
  const BRepMesh_IncrementalMesh done{shape, kAskedDeflection, false, kStepAngle_rad};
  if (!done.IsDone()) return fail("OpenCASCADE could not make triangles of it");
  ReadParts read{{}, {kMetresPerUnit, LengthUnit::Source::stated}};
  const std::string name = file.stem().string();
  for (TopExp_Explorer solids{shape, TopAbs_SOLID}; solids.More(); solids.Next()) {
    add_part(solids.Current(), name, read);
  }
  // Shells, then faces, that belong to nothing larger.
  for (TopExp_Explorer shells{shape, TopAbs_SHELL, TopAbs_SOLID}; shells.More(); shells.Next()) {
    add_part(shells.Current(), name, read);
  }
  for (TopExp_Explorer faces{shape, TopAbs_FACE, TopAbs_SHELL}; faces.More(); faces.Next()) {
    add_part(faces.Current(), name, read);
  }
  return read;
}

}  // namespace

Result<ReadParts> read_step(const std::filesystem::path& file, const Progress& progress) {
  try {
    return tessellate(file, progress);
  } catch (const Standard_Failure& error) {
    return fail(fmt::format("OpenCASCADE failed on it ({})", error.GetMessageString()));
  }
}

}  // namespace meshloop
#endif
