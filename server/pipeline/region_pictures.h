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
  /// A region that the colour camera does not see has been tried, and has none.
  struct Tried {
    int pixels = 0;
    bool has_picture = false;
  };
  std::map<RegionId, Tried> tried_;
};

}  // namespace meshloop
