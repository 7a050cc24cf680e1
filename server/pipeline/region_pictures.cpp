#include "server/pipeline/region_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "common/image/image_file.h"

namespace meshloop {
namespace {

constexpr double kBetterView = 1.5;

std::string name_of(RegionId id) {
  return fmt::format("region_{:04}.png", id);
}

}  // namespace

Status RegionPictures::update(const TrackedFrame& tracked, const Examination& examination, Views& views,
                              bool confirmed_only) {
  std::vector<RegionId> wanted;
  const auto& regions = examination.regions.regions;
  for (const Region& region : regions) {
    const auto known = tried_.find(region.id);
    const bool better = known == tried_.end() || region.pixels > kBetterView * known->second.pixels;
    if (better && (region.confirmed || !confirmed_only)) wanted.push_back(region.id);
  }
  if (wanted.empty()) return {};
  const auto thumbnails = views.thumbnails(tracked, examination, wanted);
  if (!thumbnails) return fail(thumbnails.error());
  for (const Region& region : regions) {
    if (std::find(wanted.begin(), wanted.end(), region.id) != wanted.end()) tried_[region.id].pixels = region.pixels;
  }
  for (const auto& [id, picture] : *thumbnails) {
    if (auto done = write_png(folder_ / name_of(id), picture); !done) return done;
    tried_[id].has_picture = true;
  }
  return {};
}

std::string RegionPictures::file_of(RegionId id) const {
  const auto tried = tried_.find(id);
  return tried != tried_.end() && tried->second.has_picture ? name_of(id) : std::string{};
}

}  // namespace meshloop
