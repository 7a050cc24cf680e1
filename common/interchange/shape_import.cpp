#include "common/interchange/shape_import.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/implicit/shape_file.h"
#include "common/implicit/tessellate.h"
#include "common/interchange/file_ending.h"
#include "common/mesh/lattice.h"

namespace meshloop {
namespace {

constexpr int kFinestGrid = 96;
constexpr int kCoarsestGrid = 12;

/// As fine as the limit of triangles allows.
Result<Tessellation> stand_in_of(const Shape& shape, std::size_t max_triangles) {
  for (int cells = kFinestGrid;; cells = cells * 3 / 4) {
    auto made = tessellate(shape, cells);
    if (!made || made->submesh.triangles.size() <= max_triangles) return made;
    if (cells < kCoarsestGrid) return fail("its triangles are more than a part may have");
  }
}

}  // namespace

bool is_shape_file(const std::filesystem::path& file) {
  const std::string ending = lower_case_ending(file);
  return ending == ".yaml" || ending == ".yml";
}

Result<ImportedModel> import_shapes(const std::filesystem::path& file, const ImportOptions& options) {
  if (options.unit_m && *options.unit_m != 1) {
    return fail(fmt::format("'{}' is a file of shapes, which are in metres: leave the unit out", file.string()),
                ErrorKind::usage);
  }
  const auto shapes = read_shapes(file);
  if (!shapes) return fail(shapes.error());
  ImportedModel imported;
  imported.unit = {1, LengthUnit::Source::stated};
  imported.model.revision = 1;
  Eigen::AlignedBox3f box;
  for (const auto& [name, shape] : *shapes) {
    auto stand_in = stand_in_of(shape, options.max_triangles_per_part);
    if (!stand_in) return fail(fmt::format("'{}': shape '{}'", file.string(), name), stand_in.error());
    auto snapped = snap_to_lattice(stand_in->submesh);
    if (snapped.triangles.empty()) {
      return fail(
          fmt::format("'{}': shape '{}' is smaller than {:.2f} mm", file.string(), name, kLatticeSpacing_m * 1000));
    }
    // Half a spacing along each axis.
    const double snapping_m = 0.5 * std::sqrt(3) * static_cast<double>(kLatticeSpacing_m);
    imported.stand_in_error_m = std::max(imported.stand_in_error_m, stand_in->error_m + snapping_m);
    box.extend(snapped.bounds());
    auto node = make_node(imported.model.nodes.size() + 1, name, std::move(snapped));
    node.shape = std::make_shared<const Shape>(shape);
    imported.model.nodes.push_back(std::move(node));
    if (options.progress) {
      options.progress(static_cast<double>(imported.model.nodes.size()) / static_cast<double>(shapes->size()));
    }
  }
  imported.size_m = box.sizes();
  return imported;
}

}  // namespace meshloop
