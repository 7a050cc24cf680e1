#pragma once
// Model files of other programs. The only user of assimp.
#include <filesystem>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/model.h"

namespace meshloop {

struct ImportedPart {
  std::string name;
  Submesh submesh;
};

struct ImportOptions {
  /// Parts with more triangles are split in space, so that one network sample stays below 1 MB.
  std::size_t max_triangles_per_part = 60'000;
  /// Processor seconds that reading may take.
  unsigned max_seconds = 60;
};

/// Reads OBJ, PLY, STL, OFF, glTF and GLB. Positions are metres as the file states them; transforms of the file's scene
/// graph are applied; vertex colours (or the material's base colour) are kept. The file is parsed in a child process
/// with limits, since a malformed file can crash the parser. Call before other threads hold locks that the child needs
/// (start of the program).
[[nodiscard]] Result<std::vector<ImportedPart>> import_model(const std::filesystem::path& file,
                                                             const ImportOptions& options = {});

/// A model at revision 1 with one node a part, ids from 1, positions on the scene's lattice.
[[nodiscard]] Result<Model> import_as_model(const std::filesystem::path& file, const ImportOptions& options = {});

/// Writes GLB, PLY (binary) or OBJ by the file's ending. Written beside the target and renamed, so that no half file
/// stands under its name. Nodes keep their names and transforms in GLB; PLY and OBJ hold world coordinates.
[[nodiscard]] Status export_model(const Model& model, const std::filesystem::path& file);

}  // namespace meshloop
