#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>

#include "common/base/log.h"
#include "common/interchange/file_ending.h"
#include "common/interchange/isolated_import.h"
#include "common/interchange/model_file.h"
#include "common/interchange/split.h"
#include "common/mesh/lattice.h"

namespace meshloop {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 6> kEndings{".obj", ".ply", ".stl", ".off", ".gltf", ".glb"};
/// What the codec can encode in one piece; larger parts are in other units.
constexpr float kWidestPart_m = 2047;

Status check_file(const fs::path& file) {
  std::error_code error;
  const auto status = fs::status(file, error);
  if (!fs::exists(status)) return fail(fmt::format("'{}' does not exist", file.string()));
  if (fs::is_directory(status)) return fail(fmt::format("'{}' is a folder, not a model file", file.string()));
  if (!fs::is_regular_file(status)) return fail(fmt::format("'{}' is not a regular file", file.string()));
  if (std::find(kEndings.begin(), kEndings.end(), lower_case_ending(file)) == kEndings.end()) {
    return fail(
        fmt::format("'{}' has an unknown ending; models are read from {}", file.string(), fmt::join(kEndings, ", ")));
  }
  return {};
}

void add_split(ImportedPart part, std::size_t max_triangles, std::vector<ImportedPart>& parts) {
  if (part.submesh.triangles.size() <= max_triangles) {
    parts.push_back(std::move(part));
    return;
  }
  auto pieces = split_in_space(part.submesh, max_triangles);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    parts.push_back({fmt::format("{}.{}", part.name, i + 1), std::move(pieces[i])});
  }
}

/// One node, or nothing when the part vanishes on the lattice.
Status add_node(const ImportedPart& part, Model& model) {
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
  model.nodes.push_back(make_node(model.nodes.size() + 1, part.name, std::move(snapped)));
  return {};
}

}  // namespace

Result<std::vector<ImportedPart>> import_model(const fs::path& file, const ImportOptions& options) {
  if (auto ok = check_file(file); !ok) return fail(ok.error());
  auto read = read_parts_isolated(file, options.max_seconds);
  if (!read) return fail(read.error());
  std::vector<ImportedPart> parts;
  for (auto& part : *read) {
    if (auto ok = validate(part.submesh); !ok) {
      return fail(fmt::format("'{}' could not be read", file.string()), ok.error());
    }
    add_split(std::move(part), std::max<std::size_t>(options.max_triangles_per_part, 1), parts);
  }
  if (parts.empty()) return fail(fmt::format("'{}' could not be read: it holds no triangles", file.string()));
  return parts;
}

Result<Model> import_as_model(const fs::path& file, const ImportOptions& options) {
  const auto parts = import_model(file, options);
  if (!parts) return fail(parts.error());
  Model model;
  model.revision = 1;
  for (const auto& part : *parts) {
    if (auto ok = add_node(part, model); !ok)
      return fail(fmt::format("'{}' cannot be used", file.string()), ok.error());
  }
  if (model.nodes.empty()) {
    return fail(fmt::format("'{}' holds no triangle larger than {:.2f} mm; is it in metres?", file.string(),
                            kLatticeSpacing_m * 1000));
  }
  return model;
}

}  // namespace meshloop
