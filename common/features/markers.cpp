#include "common/features/markers.h"

#include <algorithm>
#include <iterator>
#include <opencv2/aruco.hpp>
#include <string_view>

#include "common/features/square_refinement.h"

namespace meshloop {
namespace {

// In the order of cv::aruco::PREDEFINED_DICTIONARY_NAME.
constexpr std::string_view kDictionaries[]{
    "DICT_4X4_50",        "DICT_4X4_100",        "DICT_4X4_250",       "DICT_4X4_1000",      "DICT_5X5_50",
    "DICT_5X5_100",       "DICT_5X5_250",        "DICT_5X5_1000",      "DICT_6X6_50",        "DICT_6X6_100",
    "DICT_6X6_250",       "DICT_6X6_1000",       "DICT_7X7_50",        "DICT_7X7_100",       "DICT_7X7_250",
    "DICT_7X7_1000",      "DICT_ARUCO_ORIGINAL", "DICT_APRILTAG_16h5", "DICT_APRILTAG_25h9", "DICT_APRILTAG_36h10",
    "DICT_APRILTAG_36h11"};
static_assert(std::size(kDictionaries) == cv::aruco::DICT_APRILTAG_36h11 + 1);

// For reading only: OpenCV has no matrix of constant pixels.
cv::Mat view_for_reading(const GreyImage& image) {
  return {image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t*>(image.data())};
}

cv::Ptr<cv::aruco::DetectorParameters> detector_parameters() {
  const auto parameters = cv::aruco::DetectorParameters::create();
  parameters->cornerRefinementMethod = cv::aruco::CORNER_REFINE_NONE;
  return parameters;
}

}  // namespace

struct MarkerDetector::Dictionary {
  cv::Ptr<cv::aruco::Dictionary> codes;
};

MarkerDetector::MarkerDetector(std::shared_ptr<const Dictionary> dictionary) : dictionary_{std::move(dictionary)} {}

Result<MarkerDetector> MarkerDetector::create(const std::string& dictionary) {
  const auto found = std::find(std::begin(kDictionaries), std::end(kDictionaries), dictionary);
  if (found == std::end(kDictionaries)) {
    return fail("there is no marker dictionary '" + dictionary + "': use a name of OpenCV's, such as DICT_4X4_50");
  }
  const auto index = static_cast<int>(std::distance(std::begin(kDictionaries), found));
  return MarkerDetector{std::make_shared<const Dictionary>(Dictionary{cv::aruco::getPredefinedDictionary(index)})};
}

std::vector<MarkerSighting> MarkerDetector::detect(const GreyImage& image) const {
  if (image.empty()) return {};
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  cv::aruco::detectMarkers(view_for_reading(image), dictionary_->codes, corners, ids, detector_parameters());
  std::vector<MarkerSighting> sightings(ids.size());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    sightings[i].id = ids[i];
    for (std::size_t k = 0; k < 4; ++k) sightings[i].pixels[k] = {corners[i][k].x, corners[i][k].y};
    // A marker too small or too blurred for this keeps the corners that it was found with.
    const bool refined = refine_square(image, dictionary_->codes->markerSize + 2, sightings[i].pixels);
    sightings[i].sigma_px = refined ? kMarkerCornerSigmaPx : kRoughCornerSigmaPx;
  }
  return sightings;
}

Result<GreyImage> MarkerDetector::pattern(int id) const {
  const cv::aruco::Dictionary& codes = *dictionary_->codes;
  if (id < 0 || id >= codes.bytesList.rows) {
    return fail("the marker dictionary has the ids 0 to " + std::to_string(codes.bytesList.rows - 1) + ", not " +
                std::to_string(id));
  }
  const cv::Mat bits =
      cv::aruco::Dictionary::getBitsFromByteList(codes.bytesList.rowRange(id, id + 1), codes.markerSize);
  GreyImage pattern{codes.markerSize + 2, codes.markerSize + 2, 0};
  for (int y = 0; y < codes.markerSize; ++y) {
    for (int x = 0; x < codes.markerSize; ++x) {
      pattern(x + 1, y + 1) = bits.at<std::uint8_t>(y, x) != 0 ? std::uint8_t{255} : std::uint8_t{0};
    }
  }
  return pattern;
}

}  // namespace meshloop
