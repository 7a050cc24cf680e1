#include "server/store/model_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <map>

#include "server/store/blobs.h"
#include "server/store/schema.h"
#include "server/store/texture_rows.h"

namespace meshloop {
namespace {

using SubmeshPtr = std::shared_ptr<const Submesh>;

tl::unexpected<Error> damaged(const Database& database, const std::string& what) {
  return fail(fmt::format("'{}' is damaged ({}); restore it from a copy", database.file().string(), what));
}

std::span<const std::byte> blob_of(const Hash& hash) {
  return std::as_bytes(std::span{hash});
}

Result<SubmeshPtr> read_geometry(Database& database, const Hash& hash, bool with_textures) {
  auto query = database.prepare("SELECT positions, colors, triangles FROM geometry WHERE hash = ?");
  if (!query) return fail(query.error());
  const auto row = query->bind(blob_of(hash)).step();
  if (!row) return fail(row.error());
  if (!*row) return damaged(database, "a geometry is missing");
  auto positions = from_blob<Eigen::Vector3f>(query->blob(0));
  auto colors = from_blob<Rgb8>(query->blob(1));
  auto triangles = from_blob<Triangle>(query->blob(2));
  if (!positions || !colors || !triangles) return damaged(database, "a geometry has the wrong size");
  Submesh submesh{std::move(*positions), std::move(*colors), std::move(*triangles)};
  if (with_textures) {
    auto texture = read_texture(database, hash);
    if (!texture) return fail(texture.error());
    submesh.texture = std::move(*texture);
  }
  if (auto ok = validate(submesh); !ok) return damaged(database, ok.error().message);
  if (content_hash(submesh) != hash) return damaged(database, "a geometry is not what was stored");
  return std::make_shared<const Submesh>(std::move(submesh));
}

Result<Node> read_node(const Database& database, const Statement& row) {
  Node node;
  node.id = static_cast<NodeId>(row.integer(0));
  node.name = row.text(1);
  const auto pose = pose_from_blob(row.blob(2));
  const auto hash = row.blob(3);
  if (node.id == 0 || !pose || hash.size() != node.hash.size()) return damaged(database, "a node's row is not one");
  node.T_world_node = *pose;
  std::memcpy(node.hash.data(), hash.data(), hash.size());
  return node;
}

/// Bits, not numbers: 0.0 equals -0.0, and what was told to be there must be what comes back.
bool same(const Node& a, const Node& b) {
  return a.name == b.name && a.hash == b.hash &&
         std::memcmp(a.T_world_node.data(), b.T_world_node.data(), 16 * sizeof(double)) == 0;
}

Status end_row(Database& database, NodeId id, Revision revision) {
  auto update = database.prepare("UPDATE node SET to_revision = ? WHERE node_id = ? AND to_revision IS NULL");
  if (!update) return fail(update.error());
  return update->bind(static_cast<std::int64_t>(revision)).bind(static_cast<std::int64_t>(id)).run();
}

Status add_geometry(Database& database, const Node& node) {
  auto insert = database.prepare("INSERT INTO geometry VALUES(?, ?, ?, ?) ON CONFLICT DO NOTHING");
  if (!insert) return fail(insert.error());
  const Submesh& submesh = *node.submesh;
  insert->bind(blob_of(node.hash))
      .bind(meshloop::blob_of(submesh.positions))
      .bind(meshloop::blob_of(submesh.colors))
      .bind(meshloop::blob_of(submesh.triangles));
  if (auto ok = insert->run(); !ok || !submesh.texture) return ok;
  return append_texture(database, node.hash, *submesh.texture);
}

Status add_row(Database& database, const Node& node, Revision revision) {
  if (auto ok = add_geometry(database, node); !ok) return ok;
  auto insert = database.prepare("INSERT INTO node VALUES(?, ?, NULL, ?, ?, ?)");
  if (!insert) return fail(insert.error());
  const auto transform = pose_values(node.T_world_node);
  return insert->bind(static_cast<std::int64_t>(node.id))
      .bind(static_cast<std::int64_t>(revision))
      .bind(std::string_view{node.name})
      .bind(meshloop::blob_of(transform))
      .bind(blob_of(node.hash))
      .run();
}

}  // namespace

Result<Model> read_model(Database& database, Revision revision, const Model& known) {
  std::map<Hash, SubmeshPtr> shared;
  for (const auto& node : known.nodes) shared.emplace(node.hash, node.submesh);
  const auto with_textures = has_textures(database);
  if (!with_textures) return fail(with_textures.error());
  auto query = database.prepare(
      "SELECT node_id, name, transform, geometry FROM node "
      "WHERE from_revision <= ?1 AND (to_revision IS NULL OR to_revision > ?1) ORDER BY node_id");
  if (!query) return fail(query.error());
  query->bind(static_cast<std::int64_t>(revision));
  Model model;
  model.revision = revision;
  for (;;) {
    const auto row = query->step();
    if (!row) return fail(row.error());
    if (!*row) return model;
    auto node = read_node(database, *query);
    if (!node) return fail(node.error());
    if (!model.nodes.empty() && model.nodes.back().id >= node->id) return damaged(database, "a node is there twice");
    auto& submesh = shared[node->hash];
    if (!submesh) {
      auto read = read_geometry(database, node->hash, *with_textures);
      if (!read) return fail(read.error());
      submesh = std::move(*read);
    }
    node->submesh = submesh;
    model.nodes.push_back(std::move(*node));
  }
}

bool same_content(const Model& a, const Model& b) {
  return std::equal(a.nodes.begin(), a.nodes.end(), b.nodes.begin(), b.nodes.end(),
                    [](const Node& one, const Node& other) { return one.id == other.id && same(one, other); });
}

Status write_difference(Database& database, const Model& before, const Model& after) {
  for (const auto& node : before.nodes) {
    const Node* now = after.find(node.id);
    if (now != nullptr && same(node, *now)) continue;
    if (auto ok = end_row(database, node.id, after.revision); !ok) return ok;
  }
  for (const auto& node : after.nodes) {
    const Node* old = before.find(node.id);
    if (old != nullptr && same(*old, node)) continue;
    if (auto ok = add_row(database, node, after.revision); !ok) return ok;
  }
  return {};
}

}  // namespace meshloop
