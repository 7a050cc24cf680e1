#include "server/pipeline/proposal_pictures.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/image/image_file.h"

namespace meshloop {
namespace {

std::vector<RegionId> regions_of(const RegionMap& regions, const Proposal& proposal) {
  std::vector<RegionId> ids;
  for (const auto& region : regions.regions) {
    if (std::find(proposal.closes.begin(), proposal.closes.end(), region.id) != proposal.closes.end()) {
      ids.push_back(region.id);
    }
  }
  if (!ids.empty()) return ids;
  for (const auto& region : regions.regions) {
    if (region.confirmed && region.kind == proposal.kind && region.world_box.intersects(proposal.box_m)) {
      ids.push_back(region.id);
    }
  }
  return ids;
}

/// Short: it stands in one line below the picture.
std::string title_of(const Offered& offered, const std::string& when) {
  const auto& effect = offered.proposal.effect;
  const auto end = effect.rfind("; closes ");
  const auto kind = offered.proposal.move ? "" : fmt::format("{} ", name_of(offered.record.content.kind));
  return fmt::format("proposal {}{}: {}{}", offered.record.id, when, kind, effect.substr(0, end));
}

std::string name_of(const Offered& offered) {
  return fmt::format("proposal {}", offered.record.id);
}

void add_places(const Offered& offered, Framing& framing) {
  framing.places.push_back({offered.proposal.move->box_old_m, name_of(offered) + ": from"});
  framing.places.push_back({offered.proposal.move->box_new_m, name_of(offered) + ": to"});
}

Framing framing_of(const RegionMap& regions, const Offered& offered) {
  Framing framing{marked(regions, offered.proposal), {}, {}};
  Region& whole = framing.regions.regions.front();
  framing.region_texts[whole.id] = name_of(offered);
  if (!offered.proposal.move) return framing;
  whole.confirmed = false;  // its pixels show a part of what moved
  add_places(offered, framing);
  return framing;
}

}  // namespace

Framing framing_of(const RegionMap& regions, const std::vector<Offered>& offered) {
  Framing framing{regions, {}, {}};
  for (const auto& one : offered) {
    if (!one.proposal.move) continue;
    add_places(one, framing);
    for (auto& region : framing.regions.regions) {
      const auto& closed = one.proposal.closes;
      if (std::find(closed.begin(), closed.end(), region.id) != closed.end()) region.confirmed = false;
    }
  }
  for (const auto& one : offered) {
    if (one.proposal.move || one.record.id == 0) continue;
    const auto ids = regions_of(regions, one.proposal);
    for (auto& region : framing.regions.regions) {
      if (std::find(ids.begin(), ids.end(), region.id) == ids.end()) continue;
      region.confirmed = true;  // a move that closes it leaves some of it
      auto& text = framing.region_texts[region.id];
      text += (text.empty() ? "" : ", ") + name_of(one);
    }
  }
  return framing;
}

RegionMap marked(const RegionMap& regions, const Proposal& proposal) {
  const auto ids = regions_of(regions, proposal);
  Region whole;
  whole.id = proposal.id == 0 ? 1 : proposal.id;
  whole.kind = proposal.kind;
  whole.confirmed = true;
  for (const auto& region : regions.regions) {
    if (std::find(ids.begin(), ids.end(), region.id) == ids.end()) continue;
    whole.area_m2 += region.area_m2;
    whole.pixels += region.pixels;
  }
  RegionMap marked{regions.ids, {whole}};
  for (auto& id : marked.ids.pixels()) id = std::find(ids.begin(), ids.end(), id) == ids.end() ? 0 : whole.id;
  return marked;
}

Result<ProposalPictures> ProposalPictures::create(const std::filesystem::path& folder) {
  if (folder.empty()) return ProposalPictures{{}};
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail(fmt::format("cannot make the folder '{}': {}", folder.string(), error.message()));
  return ProposalPictures{folder};
}

Result<std::string> ProposalPictures::write(const TrackedFrame& tracked, const Examination& examination,
                                            const Offered& offered, Views& views) const {
  const auto framing = framing_of(examination.regions, offered);
  const auto picture = views.on_color(tracked, examination, title_of(offered, ""), &framing);
  if (!picture) return fail(picture.error());
  auto name = fmt::format("proposal_{:04}.png", offered.record.id);
  if (auto done = write_png(folder_ / name, *picture); !done) return fail(done.error());
  return name;
}

Result<std::string> ProposalPictures::write_after(const TrackedFrame& tracked, const Examination& before,
                                                  const Examination& after, const Offered& offered, Revision revision,
                                                  Views& views) const {
  const auto framing = framing_of(before.regions, offered);
  const auto title = title_of(offered, fmt::format(", after revision {}", revision));
  const auto picture = views.on_color(tracked, after, title, &framing);
  if (!picture) return fail(picture.error());
  auto name = fmt::format("proposal_{:04}_after.png", offered.record.id);
  if (auto done = write_png(folder_ / name, *picture); !done) return fail(done.error());
  return name;
}

}  // namespace meshloop
