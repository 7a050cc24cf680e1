#include "common/recording/marker_file.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "common/base/file.h"
#include "common/recording/yaml_reader.h"

namespace meshloop {
namespace {

constexpr double kSquareTolerance = 0.02;
constexpr std::size_t kMostMarkers = 1000;  // as many as the largest dictionary has

// Four equal sides and two equal diagonals of the right length make a plane square.
bool is_square(const std::array<Eigen::Vector3d, 4>& corners) {
  if (!std::all_of(corners.begin(), corners.end(), [](const auto& corner) { return corner.allFinite(); })) return false;
  std::array<double, 6> lengths{};
  for (std::size_t i = 0; i < 4; ++i) lengths[i] = (corners[(i + 1) % 4] - corners[i]).norm();
  for (std::size_t i = 0; i < 2; ++i) lengths[4 + i] = (corners[i + 2] - corners[i]).norm() / std::numbers::sqrt2;
  const double side = (lengths[0] + lengths[1] + lengths[2] + lengths[3]) / 4;
  return side > 0 && std::all_of(lengths.begin(), lengths.end(),
                                 [side](double length) { return std::abs(length - side) <= kSquareTolerance * side; });
}

Status check_markers(const MarkerMap& map) {
  if (map.dictionary.rfind("DICT_", 0) != 0) {
    return fail(
        fmt::format("'dictionary' must name an OpenCV dictionary, as in DICT_4X4_50, not '{:.40}'", map.dictionary));
  }
  if (map.markers.empty()) return fail("'markers' must name at least one marker");
  std::set<int> ids;
  for (const auto& marker : map.markers) {
    if (marker.id < 0) return fail(fmt::format("marker {} has a negative id", marker.id));
    if (!ids.insert(marker.id).second) return fail(fmt::format("marker {} stands there twice", marker.id));
    if (!is_square(marker.corners)) {
      return fail(
          fmt::format("the corners of marker {} do not form a square (to {} %)", marker.id, kSquareTolerance * 100));
    }
  }
  return {};
}

Result<Marker> parse_marker(const YAML::Node& node, const std::string& where) {
  if (auto ok = check_keys(node, where, {"id", "corners"}); !ok) return fail(ok.error());
  Marker marker;
  const auto id = read_integer(node["id"], where + ".id");
  if (!id) return fail(id.error());
  marker.id = *id;
  const YAML::Node corners = node["corners"];
  if (!corners.IsSequence() || corners.size() != marker.corners.size()) {
    return fail(fmt::format("'{}.corners' must be a list of 4 points [x, y, z]", where));
  }
  for (std::size_t i = 0; i < marker.corners.size(); ++i) {
    const auto key = fmt::format("{}.corners[{}]", where, i);
    if (auto ok = read_numbers(corners[i], key, {marker.corners[i].data(), 3}); !ok) return fail(ok.error());
  }
  return marker;
}

Result<MarkerMap> parse_markers(const YAML::Node& root) {
  if (auto ok = check_keys(root, "", {"dictionary", "markers"}); !ok) return fail(ok.error());
  const auto dictionary = read_string(root["dictionary"], "dictionary");
  if (!dictionary) return fail(dictionary.error());
  MarkerMap map{*dictionary, {}};
  const YAML::Node list = root["markers"];
  if (!list.IsSequence() || list.size() > kMostMarkers) {
    return fail(fmt::format("'markers' must be a list of at most {} markers", kMostMarkers));
  }
  for (std::size_t i = 0; i < list.size(); ++i) {
    auto marker = parse_marker(list[i], fmt::format("markers[{}]", i));
    if (!marker) return fail(marker.error());
    map.markers.push_back(*marker);
  }
  if (auto ok = check_markers(map); !ok) return fail(ok.error());
  return map;
}

}  // namespace

Result<MarkerMap> read_markers(const std::filesystem::path& file) {
  const auto root = load_yaml_map(file);
  if (!root) return fail(root.error());
  try {
    auto markers = parse_markers(*root);
    if (!markers) return fail(fmt::format("'{}'", file.string()), markers.error());
    return markers;
  } catch (const YAML::Exception& error) {
    return fail(fmt::format("'{}', line {}: {}", file.string(), error.mark.line + 1, error.msg));
  }
}

Status write_markers(const std::filesystem::path& file, const MarkerMap& markers) {
  if (auto ok = check_markers(markers); !ok) return fail(fmt::format("cannot write '{}'", file.string()), ok.error());
  std::string text = fmt::format("dictionary: {}\nmarkers:\n", markers.dictionary);
  for (const auto& marker : markers.markers) {
    text += fmt::format("  - id: {}\n    corners:\n", marker.id);
    for (const auto& p : marker.corners) text += fmt::format("      - [{}, {}, {}]\n", p.x(), p.y(), p.z());
  }
  return write_text_file(file, text);
}

}  // namespace meshloop
