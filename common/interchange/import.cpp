#include <fmt/format.h>

#include <cmath>
#include <system_error>

#include "common/base/log.h"
#include "common/interchange/isolated_import.h"
#include "common/interchange/model_file.h"
#include "common/interchange/read_file.h"
#include "common/interchange/shape_import.h"
#include "common/mesh/lattice.h"

namespace meshloop {
namespace {

namespace fs = std::filesystem;

/// What the codec can encode in one piece.
constexpr float kWidestPart_m = 2047;

std::string endings() {
  std::string text;
  for (const auto& format : model_formats()) text += fmt::format("{}{}", text.empty() ? "" : ", ", format.ending);
  return text;
}

Status check_file(const fs::path& file) {
  std::error_code error;
  const auto status = fs::status(file, error);
  if (!fs::exists(status)) return fail(fmt::format("'{}' does not exist", file.string()));
  if (fs::is_directory(status)) return fail(fmt::format("'{}' is a folder, not a model file", file.string()));
  if (!fs::is_regular_file(status)) return fail(fmt::format("'{}' is not a regular file", file.string()));
  if (format_of(file) == nullptr) {
    return fail(fmt::format("'{}' has an unknown ending; models are read from {}, and shapes from .yaml", file.string(),
                            endings()));
  }
  return {};
}

/// What the child made of the file, and validated once more here.
Result<ReadParts> read_isolated(const fs::path& file, const ImportOptions& options) {
  if (auto ok = check_file(file); !ok) return fail(ok.error());
  if (options.unit_m && !(*options.unit_m > 0 && std::isfinite(*options.unit_m))) {
    return fail("the unit's length must be a positive number of metres", ErrorKind::usage);
  }
  auto read = run_isolated(file, {options.max_seconds, options.progress},
                           [&](const Progress& progress) { return read_file(file, options, progress); });
  if (!read) return read;
  for (const auto& part : read->parts) {
    if (auto ok = validate(part.submesh); !ok) {
      return fail(fmt::format("'{}' could not be read", file.string()), ok.error());
    }
  }
  return read;
}

/// One node, or nothing when the part vanishes on the lattice.
Status add_node(ImportedPart part, Model& model) {
  auto snapped = snap_to_lattice(part.submesh);
  if (snapped.triangles.empty()) {
    log_warning("part '{}' is left out: all of its {} triangles are smaller than {:.2f} mm", part.name,
                part.submesh.triangles.size(), kLatticeSpacing_m * 1000);
    return {};
  }
  if (auto ok = validate(snapped); !ok) return ok;
  const float width = snapped.bounds().sizes().maxCoeff();
  if (width > kWidestPart_m) {
    return fail(fmt::format("part '{}' is {:.0f} m wide; is the file in metres?", part.name, width));
  }
  model.nodes.push_back(make_node(model.nodes.size() + 1, std::move(part.name), std::move(snapped)));
  return {};
}

Eigen::Vector3f size_of(const Model& model) {
  Eigen::AlignedBox3f box;
  for (const auto& node : model.nodes) box.extend(node.submesh->bounds());
  return box.sizes();
}

}  // namespace

std::string to_text(const LengthUnit& unit) {
  const auto length = unit.metres == 1 ? std::string{"metres"} : fmt::format("units of {:.6g} m", unit.metres);
  switch (unit.source) {
    case LengthUnit::Source::assumed:
      return length + " are assumed, the file states no unit";
    case LengthUnit::Source::stated:
      return length + ", as the file or its format states";
    case LengthUnit::Source::given:
      break;
  }
  return length + ", as given";
}

std::string model_file_kinds() {
  std::string kinds = "OBJ, PLY, STL, OFF, glTF, GLB, X3D, VRML 97 (.wrl), or shapes (.yaml)";
#ifdef MESHLOOP_STEP
  kinds += ", or STEP";
#endif
  return kinds;
}

Result<std::vector<ImportedPart>> import_model(const fs::path& file, const ImportOptions& options) {
  auto read = read_isolated(file, options);
  if (!read) return fail(read.error());
  return std::move(read->parts);
}

Result<ImportedModel> import_as_model(const fs::path& file, const ImportOptions& options) {
  if (is_shape_file(file)) return import_shapes(file, options);
  auto read = read_isolated(file, options);
  if (!read) return fail(read.error());
  ImportedModel imported;
  imported.unit = read->unit;
  imported.model.revision = 1;
  for (auto& part : read->parts) {
    if (auto ok = add_node(std::move(part), imported.model); !ok) {
      return fail(fmt::format("'{}' cannot be used", file.string()), ok.error());
    }
  }
  if (imported.model.nodes.empty()) {
    return fail(fmt::format("'{}' holds no triangle larger than {:.2f} mm; is it in metres?", file.string(),
                            kLatticeSpacing_m * 1000));
  }
  imported.size_m = size_of(imported.model);
  return imported;
}

}  // namespace meshloop
