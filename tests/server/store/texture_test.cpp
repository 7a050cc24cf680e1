// Textures in scene files.
#include <sqlite3.h>

#include "scenes.h"
#include "textured_wall.h"

namespace meshloop {
namespace {

using test::expect_same_content;
using test::open_or_die;
using test::textured_wall;

class TextureStore : public test::SceneFolder {
 protected:
  void run_sql(const char* sql) const {
    sqlite3* database = nullptr;
    EXPECT_EQ(sqlite3_open(scene_.c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(database, sql, nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
    sqlite3_close(database);
  }
  std::int64_t count(const char* sql) const {
    sqlite3* database = nullptr;
    sqlite3_stmt* statement = nullptr;
    EXPECT_EQ(sqlite3_open(scene_.c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_prepare_v2(database, sql, -1, &statement, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
    EXPECT_EQ(sqlite3_step(statement), SQLITE_ROW);
    const std::int64_t value = sqlite3_column_int64(statement, 0);
    sqlite3_finalize(statement);
    sqlite3_close(database);
    return value;
  }
};

TEST_F(TextureStore, ComesBackBitForBit) {
  const Submesh wall = textured_wall();
  std::shared_ptr<const Model> before;
  {
    const auto store = open_or_die(scene_);
    before = store->commit({AddNode{make_node(1, "wall", wall)}, test::add(2, 5)}, {}).value();
  }
  const auto store = open_or_die(scene_, false);
  expect_same_content(*store->model(), *before);
  const auto& read = store->model()->find(1)->submesh->texture;
  ASSERT_TRUE(read);
  EXPECT_EQ(read->jpeg, wall.texture->jpeg);
  EXPECT_EQ(read->projection, wall.texture->projection);
  EXPECT_FALSE(store->model()->find(2)->submesh->texture);
}

TEST_F(TextureStore, KeepsAPictureOnceForAllThatIsLeftOfItsSurface) {
  {
    const auto store = open_or_die(scene_);
    const Submesh wall = textured_wall();
    ASSERT_TRUE(store->commit({AddNode{make_node(1, "wall", wall)}}, {}));
    const auto half = std::make_shared<const Submesh>(keep_triangles(wall, {true, false}));
    ASSERT_TRUE(store->commit({ReplaceSubmesh{1, half}}, {}));
    EXPECT_EQ(store->undo("anna").value()->find(1)->submesh->triangles.size(), 2u);
  }
  EXPECT_EQ(count("SELECT count(*) FROM texture"), 2);
  EXPECT_EQ(count("SELECT count(*) FROM jpeg"), 1);
  const auto store = open_or_die(scene_, false);
  EXPECT_EQ(store->model_at(2).value()->find(1)->submesh->triangles.size(), 1u);
  EXPECT_TRUE(store->model_at(2).value()->find(1)->submesh->texture);
}

TEST_F(TextureStore, DamageIsNoticed) {
  {
    const auto store = open_or_die(scene_);
    ASSERT_TRUE(store->commit({AddNode{make_node(1, "wall", textured_wall())}}, {}));
  }
  const std::string good = test::content_of(scene_);
  for (const char* damage :
       {"DELETE FROM texture", "UPDATE texture SET projection = zeroblob(48)", "UPDATE texture SET projection = X'00'",
        "UPDATE jpeg SET bytes = X'FFD8FF'", "UPDATE jpeg SET bytes = substr(bytes, 1, length(bytes) - 40)",
        "PRAGMA foreign_keys=OFF; DELETE FROM jpeg"}) {
    test::write_content(scene_, good);
    run_sql(damage);
    const auto store = SceneStore::open(scene_, false);
    ASSERT_FALSE(store) << damage;
    EXPECT_NE(store.error().message.find("restore it from a copy"), std::string::npos) << store.error().message;
  }
}

}  // namespace
}  // namespace meshloop
