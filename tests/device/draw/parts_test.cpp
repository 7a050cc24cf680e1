// Presenter, head-up display and the demo's object.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

#include "common/image/image_file.h"
#include "device/draw/demo_object.h"
#include "device/draw/hud.h"
#include "device/draw/presenter.h"

namespace meshloop {
namespace {

class PresenterTest : public testing::Test {
 protected:
  PresenterTest()
      : folder_{std::filesystem::temp_directory_path() / ("meshloop-presenter-" + std::to_string(::getpid()))} {
    std::filesystem::remove_all(folder_);
  }
  ~PresenterTest() override { std::filesystem::remove_all(folder_); }
  const std::filesystem::path folder_;
};

TEST_F(PresenterTest, WritesEveryNthPictureUnderItsPosition) {
  auto presenter = OffscreenPresenter::create({folder_ / "a" / "b", 2});
  ASSERT_TRUE(presenter) << presenter.error().message;
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE((*presenter)->show(ColorImage{20, 16, {static_cast<std::uint8_t>(i), 0, 9}}));
  }
  const auto second = read_color_image(folder_ / "a" / "b" / "000002.png");
  ASSERT_TRUE(second) << second.error().message;
  EXPECT_EQ(*second, (ColorImage{20, 16, {2, 0, 9}}));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "a" / "b" / "000000.png"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a" / "b" / "000001.png"));
}

TEST_F(PresenterTest, RefusesAFolderThatCannotBeMade) {
  std::filesystem::create_directories(folder_);
  std::ofstream{folder_ / "file"} << "x";
  for (const auto& bad : {folder_ / "file", folder_ / "file" / "below"}) {
    const auto refused = OffscreenPresenter::create({bad, 1});
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find(bad.string()), std::string::npos) << refused.error().message;
  }
}

TEST_F(PresenterTest, RefusesEveryZerothPicture) {
  const auto refused = OffscreenPresenter::create({folder_, 0});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::usage);
}

TEST_F(PresenterTest, SaysWhenAPictureCannotBeWritten) {
  auto presenter = OffscreenPresenter::create({folder_, 1});
  ASSERT_TRUE(presenter);
  std::filesystem::remove_all(folder_);
  EXPECT_FALSE((*presenter)->show(ColorImage{20, 16}));
}

TEST(Hud, SaysRevisionStateAndRate) {
  EXPECT_EQ(hud_text({4, "tracking", 28.4}), "revision 4 | tracking | 28 frames/s");
  EXPECT_EQ(hud_text({0, "tracking", 0}), "tracking");
  EXPECT_EQ(hud_text({0, "", 0}), "");
}

TEST(Hud, StaysInTheLowerLeftCornerAndLeavesTinyPicturesAlone) {
  const ColorImage plain{320, 240, {200, 200, 200}};
  ColorImage picture = plain;
  draw_hud(picture, {4, "tracking", 28});
  int changed = 0;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      if (picture(x, y) == plain(x, y)) continue;
      ++changed;
      ASSERT_GT(y, 205);
      ASSERT_LT(x, 300);
    }
  }
  EXPECT_GT(changed, 500);
  ColorImage tiny{16, 16, {9, 9, 9}};
  draw_hud(tiny, {4, "tracking", 28});
  EXPECT_EQ(tiny, (ColorImage{16, 16, {9, 9, 9}}));
  ColorImage nothing;
  draw_hud(nothing, {});
  EXPECT_TRUE(nothing.empty());
}

TEST(Lighthouse, IsAValidMeshOfItsHeightOnTheGround) {
  const Submesh mesh = make_lighthouse(0.18);
  EXPECT_TRUE(validate(mesh));
  EXPECT_GE(mesh.triangles.size(), 2000u);
  EXPECT_LE(mesh.triangles.size(), 10000u);
  const auto bounds = mesh.bounds();
  EXPECT_NEAR(bounds.min().z(), 0, 1e-6);
  EXPECT_NEAR(bounds.max().z(), 0.18, 1e-6);
  EXPECT_LT(bounds.sizes().head<2>().maxCoeff(), 0.13f);
}

TEST(Lighthouse, ItsFacesLookOutwardAndHaveArea) {
  const Submesh mesh = make_lighthouse(1);
  double volume = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3f& p = mesh.positions[a];
    const Eigen::Vector3f area = (mesh.positions[b] - p).cross(mesh.positions[c] - p);
    ASSERT_GT(area.norm(), 1e-9f);
    volume += static_cast<double>(p.dot(area)) / 6;
  }
  // Between a needle and a cylinder.
  EXPECT_GT(volume, 0.02);
  EXPECT_LT(volume, 0.15);
}

}  // namespace
}  // namespace meshloop
