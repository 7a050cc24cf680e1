#include "server/adjust/patch_border.h"

#include <set>

namespace meshloop::adjust {

std::vector<std::vector<std::uint32_t>> PatchBorder::lines() const {
  std::vector<std::vector<std::uint32_t>> all;
  std::set<std::uint32_t> seen;
  const auto walk = [&](std::uint32_t first) {
    auto& line = all.emplace_back();
    for (auto v = first; v != kNoVertex && seen.insert(v).second; v = next(v)) line.push_back(v);
  };
  for (const auto& [from, to] : next_) {
    if (previous(from) == kNoVertex) walk(from);
  }
  for (const auto& [from, to] : next_) {
    if (!seen.contains(from)) walk(from);
  }
  return all;
}

}  // namespace meshloop::adjust
