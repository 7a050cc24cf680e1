#pragma once
// A folder with one small picture of each region.
#include <filesystem>
#include <map>
#include <string>

#include "server/pipeline/views.h"

namespace meshloop {

class RegionPictures {
 public:
  /// The folder must be there.
  explicit RegionPictures(std::filesystem::path folder) : folder_{std::move(folder)} {}

  /// Writes a picture of each region of the frame that has none yet, or is seen with half as many pixels again as in
  /// its picture; with `confirmed_only` of the confirmed ones.
  [[nodiscard]] Status update(const TrackedFrame& tracked, const Examination& examination, Views& views,
                              bool confirmed_only);
  /// The file of a region inside the folder, empty when there is none.
  [[nodiscard]] std::string file_of(RegionId id) const;

 private:
  std::filesystem::path folder_;
  /// Pixels of each region in its picture.
  std::map<RegionId, int> pixels_;
};

}  // namespace meshloop
