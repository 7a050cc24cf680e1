// What the importing child process hands to its parent.
#include "common/interchange/part_buffer.h"

#include <gtest/gtest.h>

#include <memory>
#include <span>
#include <vector>

#include "textured_wall.h"

namespace meshloop {
namespace {

std::vector<std::byte> bytes_of(const ReadParts& read) {
  std::vector<std::byte> bytes;
  EXPECT_TRUE(write_parts(read, [&bytes](std::span<const std::byte> more) {
    bytes.insert(bytes.end(), more.begin(), more.end());
    return true;
  }));
  return bytes;
}

ReadParts two_parts() {
  ReadParts read{{{"wall", test::textured_wall()}, {"", test::textured_wall()}}, {0.001, LengthUnit::Source::stated}};
  read.parts[1].submesh.texture.reset();
  return read;
}

ReadParts part_of(const Submesh& submesh) {
  return {{{"part", submesh}}, {1, LengthUnit::Source::stated}};
}

TEST(PartBuffer, GivesBackWhatWasWritten) {
  const ReadParts given = two_parts();
  const auto written = bytes_of(given);
  const auto read = parts_from_bytes(written);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->unit.metres, 0.001);
  EXPECT_EQ(read->unit.source, LengthUnit::Source::stated);
  ASSERT_EQ(read->parts.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read->parts[i].name, given.parts[i].name);
    EXPECT_EQ(content_hash(read->parts[i].submesh), content_hash(given.parts[i].submesh));
  }
  EXPECT_EQ(bytes_of(*read), written);
}

TEST(PartBuffer, RefusesEveryTruncationAndExtraBytes) {
  Submesh triangle;
  triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  triangle.colors = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  triangle.triangles = {{0, 1, 2}};
  ReadParts read = part_of(triangle);
  triangle.colors.clear();
  read.parts.push_back({"", triangle});
  auto bytes = bytes_of(read);
  ASSERT_TRUE(parts_from_bytes(bytes));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(parts_from_bytes(std::span{bytes}.first(size))) << size;
  }
  bytes.push_back(std::byte{0});
  EXPECT_FALSE(parts_from_bytes(bytes));
}

TEST(PartBuffer, RefusesAProjectionWithoutAPicture) {
  auto texture = std::make_shared<ProjectedTexture>();
  texture->projection.setOnes();
  Submesh submesh;
  submesh.texture = texture;
  EXPECT_FALSE(parts_from_bytes(bytes_of(part_of(submesh))));
}

TEST(PartBuffer, SaysWhenTheBytesWereNotTaken) {
  EXPECT_FALSE(write_parts(two_parts(), [](std::span<const std::byte>) { return false; }));
}

}  // namespace
}  // namespace meshloop
