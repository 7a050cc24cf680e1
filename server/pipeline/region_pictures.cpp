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
    const auto known = pixels_.find(region.id);
    const bool better = known == pixels_.end() || region.pixels > kBetterView * known->second;
    if (better && (region.confirmed || !confirmed_only)) wanted.push_back(region.id);
  }
  if (wanted.empty()) return {};
  const auto thumbnails = views.thumbnails(tracked, examination, wanted);
  if (!thumbnails) return fail(thumbnails.error());
  for (const auto& [id, picture] : *thumbnails) {
    if (auto done = write_png(folder_ / name_of(id), picture); !done) return done;
    const auto region = std::find_if(regions.begin(), regions.end(), [id = id](const Region& r) { return r.id == id; });
    pixels_[id] = region->pixels;
  }
  return {};
}

std::string RegionPictures::file_of(RegionId id) const {
  return pixels_.contains(id) ? name_of(id) : std::string{};
}

}  // namespace meshloop
