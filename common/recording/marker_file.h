#pragma once
#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "common/base/result.h"

namespace meshloop {

/// A square marker with its corners in the model's frame.
struct Marker {
  int id = 0;
  /// In metres; clockwise from the upper left, seen from the front (the order of OpenCV's detector).
  std::array<Eigen::Vector3d, 4> corners;
};

struct MarkerMap {
  /// Name of an OpenCV dictionary, as in "DICT_4X4_50".
  std::string dictionary;
  std::vector<Marker> markers;
};

/// markers.yaml (see the folder's README). Refuses corners that are not finite or do not form a square (to 2 %).
[[nodiscard]] Result<MarkerMap> read_markers(const std::filesystem::path& file);
[[nodiscard]] Status write_markers(const std::filesystem::path& file, const MarkerMap& markers);

}  // namespace meshloop
