#pragma once
// Model files of other programs.
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/model.h"

namespace meshloop {

struct ImportedPart {
  std::string name;
  Submesh submesh;
};

/// How long one unit of a file's coordinates is, and how this is known.
struct LengthUnit {
  enum class Source : std::uint8_t {
    /// The format knows no unit: metres are assumed.
    assumed,
    /// The file, or the format's definition, says so.
    stated,
    /// ImportOptions::unit_m says so.
    given,
  };
  double metres = 1;
  Source source = Source::assumed;
};

/// One line for people: "metres are assumed, the file states no unit".
[[nodiscard]] std::string to_text(const LengthUnit& unit);

struct ImportOptions {
  /// Parts with more triangles are split, things before space (split.h), so that one network sample stays below 1 MB.
  std::size_t max_triangles_per_part = 60'000;
  /// Processor seconds that reading may take.
  unsigned max_seconds = 60;
  /// Metres per unit of the file, whatever the file says; then any size is taken for meant. Positive.
  std::optional<double> unit_m = std::nullopt;
  /// Called in the calling thread with the share that is done, 0 to 1, a few times a second at most.
  std::function<void(double)> progress = {};
};

struct ImportedModel {
  Model model;
  LengthUnit unit;
  /// Of all nodes together, metres.
  Eigen::Vector3f size_m = Eigen::Vector3f::Zero();
  /// How far the triangles that stand in for shapes are from them at most, metres; 0 without shapes.
  double stand_in_error_m = 0;
};

/// Reads the formats of `model_file_kinds` except shapes (`import_as_model` reads those too). Transforms of the file's
/// scene graph are applied; vertex colours (or the material's base colour) are kept. A model of more than 1000 m or
/// less than 1 cm is refused unless `unit_m` is given, since its unit is most likely another one. The file is parsed in
/// a child process with limits, since a malformed file can crash the parser. Call before other threads hold locks that
/// the child needs (start of the program).
[[nodiscard]] Result<std::vector<ImportedPart>> import_model(const std::filesystem::path& file,
                                                             const ImportOptions& options = {});

/// A model at revision 1 with one node a part, ids from 1, positions on the scene's lattice. Reads files of shapes
/// (.yaml, common/implicit) as well: their nodes have a shape, and triangles that stand in for it.
[[nodiscard]] Result<ImportedModel> import_as_model(const std::filesystem::path& file,
                                                    const ImportOptions& options = {});

/// "OBJ, PLY, STL, ...": what this build reads, for help texts.
[[nodiscard]] std::string model_file_kinds();

/// Writes GLB, PLY (binary) or OBJ by the file's ending. Written beside the target and renamed, so that no half file
/// stands under its name. Nodes keep their names and transforms in GLB; PLY and OBJ hold world coordinates.
[[nodiscard]] Status export_model(const Model& model, const std::filesystem::path& file);

}  // namespace meshloop
