// OpenCV's own pictures of printed markers, where they are at hand.
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "common/features/markers.h"
#include "common/image/image_file.h"

namespace meshloop {
namespace {

TEST(MarkerDetector, ReadsPrintedMarkersInAPhotograph) {
  const auto root = std::filesystem::path{__FILE__}.parent_path() / "../../../..";
  const auto file = root / "shared/data/aruco_opencv/singlemarkersoriginal.jpg";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "needs OpenCV's sample picture singlemarkersoriginal.jpg";
  const auto image = read_color_image(file);
  ASSERT_TRUE(image) << image.error().message;
  const auto detector = MarkerDetector::create("DICT_6X6_250");
  std::set<int> ids;
  for (const MarkerSighting& sighting : detector->detect(to_grey(*image))) {
    ids.insert(sighting.id);
    for (std::size_t k = 0; k < 4; ++k) {
      const double side = (sighting.pixels[k] - sighting.pixels[(k + 1) % 4]).norm();
      EXPECT_GT(side, 15) << "marker " << sighting.id;
      EXPECT_LT(side, 60) << "marker " << sighting.id;
    }
  }
  EXPECT_EQ(ids, (std::set<int>{23, 40, 62, 98, 124, 203}));
}

}  // namespace
}  // namespace meshloop
