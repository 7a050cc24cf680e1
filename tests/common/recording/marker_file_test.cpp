#include "common/recording/marker_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "common/base/file.h"
#include "recordings.h"
#include "temporary_folder.h"

namespace meshloop {
namespace {

using testing::HasSubstr;

constexpr const char* kExample = R"(
dictionary: DICT_4X4_50
markers:
  - id: 0
    corners: [[0, 0.1, 0], [0.1, 0.1, 0], [0.1, 0, 0], [0, 0, 0]]
  - {id: 7, corners: [[1, 0, 1], [1, 0.2, 1], [1, 0.2, 0.8], [1, 0, 0.8]]}
)";

class MarkerFile : public testing::Test {
 protected:
  Result<MarkerMap> read(const std::string& text) {
    EXPECT_TRUE(write_text_file(file_, text));
    return read_markers(file_);
  }
  std::string error_of(const std::string& from, const std::string& to) {
    const auto markers = read(replaced(kExample, from, to));
    return markers ? "no error" : markers.error().message;
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "markers.yaml";
};

TEST_F(MarkerFile, ReadsCornersInTheirOrder) {
  const auto markers = read(kExample);
  ASSERT_TRUE(markers) << markers.error().message;
  EXPECT_EQ(markers->dictionary, "DICT_4X4_50");
  ASSERT_EQ(markers->markers.size(), 2u);
  EXPECT_EQ(markers->markers[1].id, 7);
  EXPECT_EQ(markers->markers[1].corners[2], Eigen::Vector3d(1, 0.2, 0.8));
}

TEST_F(MarkerFile, WrittenMarkersComeBackToTheBit) {
  MarkerMap map{"DICT_APRILTAG_36h11", {}};
  const double a = 0.1 / 3;
  map.markers.push_back({3, {{{0, a, 1e-20}, {a, a, 0}, {a, 0, 0}, {0, 0, 0}}}});
  ASSERT_TRUE(write_markers(file_, map));
  const auto read_back = read_markers(file_);
  ASSERT_TRUE(read_back) << read_back.error().message;
  EXPECT_EQ(read_back->dictionary, map.dictionary);
  EXPECT_EQ(read_back->markers.at(0).corners, map.markers[0].corners);
}

TEST_F(MarkerFile, CornersMustFormASquareToTwoPercent) {
  EXPECT_EQ(error_of("[0, 0.1, 0]", "[0, 0.101, 0]"), "no error");
  EXPECT_THAT(error_of("[0, 0.1, 0]", "[0, 0.105, 0]"), HasSubstr("marker 0 do not form a square"));
  EXPECT_THAT(error_of("[0, 0.1, 0]", "[0, 0.1, 0.03]"), HasSubstr("marker 0"));
  EXPECT_THAT(error_of("[1, 0, 1], [1, 0.2, 1]", "[1, 0.2, 1], [1, 0, 1]"), HasSubstr("marker 7"));
  EXPECT_THAT(
      read("dictionary: DICT_4X4_50\nmarkers: [{id: 1, corners: [[0,0,0],[0,0,0],[0,0,0],[0,0,0]]}]").error().message,
      HasSubstr("marker 1"));
}

TEST_F(MarkerFile, MistakesNameTheKey) {
  EXPECT_THAT(error_of("[0, 0.1, 0]", "[0, .inf, 0]"), HasSubstr("'markers[0].corners[0][1]' must be a finite number"));
  EXPECT_THAT(error_of("[0, 0.1, 0], ", ""), HasSubstr("'markers[0].corners' must be a list of 4 points"));
  EXPECT_THAT(error_of("id: 7", "id: 0"), HasSubstr("marker 0 stands there twice"));
  EXPECT_THAT(error_of("id: 7", "id: -7"), HasSubstr("negative"));
  EXPECT_THAT(error_of("id: 7", "number: 7"), HasSubstr("unknown key 'markers[1].number'; use id, corners"));
  EXPECT_THAT(error_of("DICT_4X4_50", "aruco"), HasSubstr("DICT_4X4_50"));
  EXPECT_THAT(read("dictionary: DICT_4X4_50\nmarkers: []").error().message, HasSubstr("at least one marker"));
  EXPECT_THAT(read("dictionary: DICT_4X4_50\nmarkers: 5").error().message, HasSubstr("must be a list"));
}

TEST_F(MarkerFile, MarkersThatCannotBeReadAreNotWritten) {
  MarkerMap map{"DICT_4X4_50", {{1, {}}}};
  for (auto& corner : map.markers[0].corners) corner.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THAT(write_markers(file_, map).error().message, HasSubstr("marker 1"));
  EXPECT_FALSE(std::filesystem::exists(file_));
}

}  // namespace
}  // namespace meshloop
