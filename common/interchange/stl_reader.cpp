#include "common/interchange/stl_reader.h"

#include <array>
#include <bit>
#include <cstring>

#include "common/interchange/mapped_file.h"
#include "common/interchange/scene_reader.h"

namespace meshloop {
namespace {

static_assert(std::endian::native == std::endian::little, "STL is little-endian");

// A header of any bytes, the count, then for each triangle a normal, three corners and two bytes.
constexpr std::size_t kHeader = 80;
constexpr std::size_t kFirstTriangle = 84;
constexpr std::size_t kNormal = 12;
constexpr std::size_t kTriangle = 50;

std::uint32_t count_of(std::string_view content) {
  std::uint32_t count = 0;
  std::memcpy(&count, content.data() + kHeader, sizeof count);
  return count;
}

}  // namespace

bool is_binary_stl(std::string_view content) {
  return content.size() >= kFirstTriangle &&
         content.size() == kFirstTriangle + kTriangle * std::size_t{count_of(content)};
}

Submesh parse_binary_stl(std::string_view content) {
  Submesh mesh;
  if (!is_binary_stl(content)) return mesh;
  const std::uint32_t count = count_of(content);
  if (count > kMaxTriangles) return mesh;
  mesh.positions.resize(std::size_t{count} * 3);
  mesh.triangles.reserve(count);
  for (std::uint32_t t = 0; t < count; ++t) {
    const char* const corners = content.data() + kFirstTriangle + kTriangle * std::size_t{t} + kNormal;
    for (std::uint32_t k = 0; k < 3; ++k) {
      std::memcpy(mesh.positions[std::size_t{t} * 3 + k].data(), corners + 12 * k, 12);
    }
    mesh.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  return mesh;
}

Result<ReadParts> read_stl(const std::filesystem::path& file, const Progress& progress) {
  const auto content = MappedFile::open(file);
  if (!content) return fail(content.error());
  if (!is_binary_stl(content->text())) return read_with_assimp(file, progress);
  if (count_of(content->text()) > kMaxTriangles) return fail("it has more triangles than are accepted");
  ReadParts read;
  auto mesh = parse_binary_stl(content->text());
  if (!mesh.triangles.empty()) read.parts.push_back({file.stem().string(), std::move(mesh)});
  return read;
}

}  // namespace meshloop
