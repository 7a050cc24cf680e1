#include "server/store/texture_rows.h"

#include <fmt/format.h>

#include <cstring>
#include <vector>

#include "server/store/blobs.h"

namespace meshloop {
namespace {

std::span<const std::byte> blob_of(const Hash& hash) {
  return std::as_bytes(std::span{hash});
}

Status append_jpeg(Database& database, const Hash& hash, std::span<const std::byte> bytes) {
  auto insert = database.prepare("INSERT INTO jpeg VALUES(?, ?) ON CONFLICT DO NOTHING");
  if (!insert) return fail(insert.error());
  return insert->bind(blob_of(hash)).bind(bytes).run();
}

}  // namespace

Result<std::shared_ptr<const ProjectedTexture>> read_texture(Database& database, const Hash& geometry) {
  auto query = database.prepare(
      "SELECT projection, bytes FROM texture LEFT JOIN jpeg ON jpeg.hash = texture.jpeg WHERE geometry = ?");
  if (!query) return fail(query.error());
  const auto row = query->bind(blob_of(geometry)).step();
  if (!row) return fail(row.error());
  if (!*row) return nullptr;
  TextureProjection projection;
  const auto values = query->blob(0);
  const auto jpeg = query->blob(1);
  const auto damaged = [&](const std::string& what) {
    return fail(fmt::format("'{}' is damaged ({}); restore it from a copy", database.file().string(), what));
  };
  if (values.size() != sizeof projection) return damaged("a texture's projection has the wrong size");
  std::memcpy(projection.data(), values.data(), values.size());
  auto texture = make_projected_texture({jpeg.begin(), jpeg.end()}, projection);
  if (!texture) return damaged(texture.error().message);
  return texture;
}

Status append_texture(Database& database, const Hash& geometry, const ProjectedTexture& texture) {
  const Hash hash = hash_of(texture.jpeg);
  if (auto ok = append_jpeg(database, hash, texture.jpeg); !ok) return ok;
  auto insert = database.prepare("INSERT INTO texture VALUES(?, ?, ?) ON CONFLICT DO NOTHING");
  if (!insert) return fail(insert.error());
  const std::span projection{texture.projection.data(), static_cast<std::size_t>(texture.projection.size())};
  return insert->bind(blob_of(geometry)).bind(blob_of(hash)).bind(std::as_bytes(projection)).run();
}

}  // namespace meshloop
