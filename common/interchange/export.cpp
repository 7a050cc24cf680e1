#include <fmt/format.h>

#include "common/base/file.h"
#include "common/interchange/file_ending.h"
#include "common/interchange/model_file.h"
#include "common/interchange/writers.h"

namespace meshloop {

Status export_model(const Model& model, const std::filesystem::path& file) {
  const std::string ending = lower_case_ending(file);
  const auto writer = ending == ".glb" ? to_glb : ending == ".ply" ? to_ply : ending == ".obj" ? to_obj : nullptr;
  if (writer == nullptr) {
    return fail(fmt::format("'{}' has an unknown ending; models are written to .glb, .ply or .obj", file.string()));
  }
  if (model.nodes.empty()) return fail("the scene has no nodes yet, so that there is nothing to export");
  const auto bytes = writer(model);
  if (!bytes) return fail(fmt::format("cannot write '{}'", file.string()), bytes.error());
  return replace_file(file, *bytes);
}

}  // namespace meshloop
