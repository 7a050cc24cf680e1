#include "server/pipeline/scene_history.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "common/image/image_file.h"

namespace meshloop {
namespace {

namespace fs = std::filesystem;

std::vector<std::byte> striped_picture() {
  ColorImage picture{64, 48};
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) picture(x, y) = Rgb8{static_cast<std::uint8_t>(x * y % 251), 0, 7};
  }
  return encode_png(picture).value();
}

TEST(SceneHistory, KeepsTheImportWhileTheStationRuns) {
  RevisionInfo change;
  change.revision = 1;
  change.summary = "imported model.ply";
  EXPECT_THAT(why_not_undone_live(change).value(),
              testing::AllOf(testing::HasSubstr("revision 1"), testing::HasSubstr("scene undo")));
  change.summary = "revision 1 restored";
  EXPECT_FALSE(why_not_undone_live(change));
  change.summary = "proposal 1: +3 triangles";
  change.proposals.emplace_back();
  EXPECT_FALSE(why_not_undone_live(change));
}

TEST(SceneHistory, WritesNoDamagedPicture) {
  const fs::path folder = fs::temp_directory_path() / ("meshloop-history-" + std::to_string(::getpid()));
  fs::create_directories(folder);
  auto store = SceneStore::open(folder / "a.db", true).value();
  RevisionInfo info;
  auto damaged = striped_picture();
  ASSERT_GT(damaged.size(), 200u);
  std::fill_n(damaged.begin() + 100, 40, std::byte{0x55});
  info.pictures = {striped_picture(), damaged};
  store->commit({}, info).value();
  const auto done = print_log(*store, false, (folder / "pictures").string());
  ASSERT_FALSE(done);
  EXPECT_THAT(done.error().message, testing::HasSubstr("1 damaged picture was not written"));
  EXPECT_TRUE(fs::exists(folder / "pictures" / "revision_0001_1.png"));
  EXPECT_FALSE(fs::exists(folder / "pictures" / "revision_0001_2.png"));
  store.reset();
  fs::remove_all(folder);
}

}  // namespace
}  // namespace meshloop
