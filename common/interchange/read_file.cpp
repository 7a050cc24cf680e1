#include "common/interchange/read_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "common/interchange/file_ending.h"
#include "common/interchange/gltf_reader.h"
#include "common/interchange/ply_reader.h"
#include "common/interchange/scene_reader.h"
#include "common/interchange/split.h"
#include "common/interchange/stl_reader.h"
#include "common/interchange/vrml_reader.h"
#include "common/interchange/weld.h"
#include "common/interchange/x3d_reader.h"
#ifdef MESHLOOP_STEP
#include "common/interchange/step_reader.h"
#endif

namespace meshloop {
namespace {

constexpr std::array kFormats{
    ModelFormat{".obj", read_with_assimp}, ModelFormat{".ply", read_ply},   ModelFormat{".stl", read_stl},
    ModelFormat{".off", read_with_assimp}, ModelFormat{".gltf", read_gltf}, ModelFormat{".glb", read_gltf},
    ModelFormat{".x3d", read_x3d},         ModelFormat{".wrl", read_vrml},
#ifdef MESHLOOP_STEP
    ModelFormat{".step", read_step},       ModelFormat{".stp", read_step},
#endif
};

/// Shares of the work that are done after reading, and after vertices were joined.
constexpr double kRead = 0.4;
constexpr double kJoined = 0.7;

/// Between them lies whatever a depth camera could be pointed at.
constexpr double kSmallestModel_m = 0.01;
constexpr double kLargestModel_m = 1000;

double longest_side(const std::vector<ImportedPart>& parts) {
  Eigen::AlignedBox3d box;
  for (const auto& part : parts) {
    for (const auto& p : part.submesh.positions) {
      if (p.allFinite()) box.extend(p.cast<double>());
    }
  }
  return box.isEmpty() ? 0 : box.sizes().maxCoeff();
}

/// A unit that would make the model as large as a room or a piece of furniture.
std::string unit_hint(double side) {
  struct Unit {
    const char* name;
    double metres;
  };
  for (const auto& unit : {Unit{"mm", 0.001}, Unit{"cm", 0.01}, Unit{"in", 0.0254}, Unit{"ft", 0.3048}}) {
    if (side > kLargestModel_m && side * unit.metres < 100) return fmt::format("--unit {}", unit.name);
  }
  return "--scale METRES";
}

Status check_size(const std::vector<ImportedPart>& parts) {
  const double side = longest_side(parts);
  if (side == 0) return fail("it has no extent: all its vertices lie at one place, or are no finite numbers");
  if (side >= kSmallestModel_m && side <= kLargestModel_m) return {};
  return fail(
      fmt::format("the model is {:.4g} metres long; say how long one of the file's units is (such as {}), also "
                  "when that is meant (--unit m)",
                  side, unit_hint(side)));
}

void scale(std::vector<ImportedPart>& parts, double metres) {
  if (metres == 1) return;
  for (auto& part : parts) {
    for (auto& p : part.submesh.positions) p = (p.cast<double>() * metres).cast<float>();
    if (!part.submesh.texture) continue;
    auto scaled = std::make_shared<ProjectedTexture>(*part.submesh.texture);
    scaled->projection.leftCols<3>() /= static_cast<float>(metres);
    part.submesh.texture = std::move(scaled);
  }
}

void add_split(ImportedPart part, std::size_t max_triangles, std::vector<ImportedPart>& parts) {
  if (part.submesh.triangles.size() <= max_triangles) {
    parts.push_back(std::move(part));
    return;
  }
  auto pieces = split(part.submesh, max_triangles);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    parts.push_back({fmt::format("{}.{}", part.name, i + 1), std::move(pieces[i])});
  }
}

}  // namespace

std::span<const ModelFormat> model_formats() {
  return kFormats;
}

const ModelFormat* format_of(const std::filesystem::path& file) {
  const std::string ending = lower_case_ending(file);
  const auto found = std::find_if(kFormats.begin(), kFormats.end(),
                                  [&](const ModelFormat& format) { return format.ending == ending; });
  return found == kFormats.end() ? nullptr : &*found;
}

Result<ReadParts> read_file(const std::filesystem::path& file, const ImportOptions& options, const Progress& progress) {
  const ModelFormat* const format = format_of(file);
  if (format == nullptr) return fail("its ending is unknown");
  auto read = format->read(file, [&progress](double share) { progress(kRead * share); });
  if (!read) return read;
  if (options.unit_m) read->unit = {*options.unit_m, LengthUnit::Source::given};
  scale(read->parts, read->unit.metres);
  if (read->parts.empty()) return fail("it holds no triangles");
  if (!options.unit_m) {
    if (auto ok = check_size(read->parts); !ok) return fail(ok.error());
  }
  progress(kRead);
  ReadParts done{{}, read->unit};
  const std::size_t max_triangles = std::max<std::size_t>(options.max_triangles_per_part, 1);
  for (auto& part : read->parts) {
    if (auto ok = validate(part.submesh); !ok) return fail(ok.error());
    ImportedPart joined{part.name, welded(std::move(part.submesh))};
    progress(kJoined);
    add_split(std::move(joined), max_triangles, done.parts);
  }
  progress(1);
  return done;
}

}  // namespace meshloop
