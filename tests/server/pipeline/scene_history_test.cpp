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

TEST(SceneHistory, TellsWhatWouldEmptyTheScene) {
  const fs::path folder = fs::temp_directory_path() / ("meshloop-empty-" + std::to_string(::getpid()));
  fs::create_directories(folder);
  auto store = SceneStore::open(folder / "a.db", true).value();
  Submesh triangle;
  triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  triangle.triangles = {{0, 1, 2}};
  const AddNode one{make_node(1, "one", triangle)};
  const AddNode two{make_node(2, "two", triangle)};
  EXPECT_FALSE(would_empty(*store, true).value()) << "there is nothing to undo";
  store->commit({one}, {}).value();
  EXPECT_TRUE(would_empty(*store, true).value());
  EXPECT_FALSE(would_empty(*store, false).value()) << "there is nothing to redo";
  store->commit({two}, {}).value();
  EXPECT_FALSE(would_empty(*store, true).value());
  store->undo("anna").value();
  store->undo("anna").value();
  EXPECT_FALSE(would_empty(*store, false).value()) << "it is empty already";
  store->restore(1, "anna").value();
  EXPECT_TRUE(would_empty(*store, true).value()) << "it was empty before it was restored";
  store->restore(0, "anna").value();
  store->undo("anna").value();
  EXPECT_TRUE(would_empty(*store, false).value());
  fs::remove_all(folder);
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
