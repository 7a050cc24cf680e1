#include "server/pipeline/result_json.h"

#include <utility>

namespace meshloop {
namespace {

nlohmann::json box_json(const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return nullptr;
  return {{"min", {box.min().x(), box.min().y(), box.min().z()}},
          {"max", {box.max().x(), box.max().y(), box.max().z()}}};
}

}  // namespace

nlohmann::json counts_json(const Comparison& comparison) {
  nlohmann::json json;
  const auto counts = comparison.counts();
  for (const auto& label : kLabels) json[std::string(label.name)] = counts[static_cast<std::size_t>(label.label)];
  return json;
}

nlohmann::json region_json(const Region& region) {
  return {{"id", region.id},
          {"kind", region.kind == ChangeKind::insertion ? "insertion" : "removal"},
          {"pixels", region.pixels},
          {"area_m2", region.area_m2},
          {"mean_difference_m", region.mean_difference_m},
          {"max_difference_m", region.max_difference_m},
          {"significance", region.significance},
          {"box_m", box_json(region.world_box)},
          {"frames_seen", region.frames_seen},
          {"confirmed", region.confirmed}};
}

nlohmann::json times_json(const Examination& examination) {
  const auto& times = examination.times;
  return {{"upload", times.upload_ms},         {"render", times.render_ms},     {"compare", times.compare_ms},
          {"regions", examination.regions_ms}, {"readback", times.readback_ms}, {"total", examination.total_ms}};
}

nlohmann::json revision_json(const RevisionInfo& info) {
  return {{"revision", info.revision},
          {"parent", info.parent},
          {"accepted_ns", info.accepted_ns},
          {"author", info.author},
          {"summary", info.summary},
          {"triangles_added", info.triangles_added},
          {"triangles_removed", info.triangles_removed},
          {"pictures", info.pictures.size()}};
}

}  // namespace meshloop
