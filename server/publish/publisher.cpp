#include "server/publish/publisher.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "common/base/clock.h"
#include "common/base/log.h"
#include "server/publish/encode_nodes.h"

namespace meshloop {
namespace {

// The display thread and the tracker want the other cores.
constexpr unsigned kEncodingThreads = 2;

bool is_continuation(char c) {
  return (static_cast<unsigned char>(c) & 0xc0) == 0x80;
}

// A manifest carries a name's first bytes only; a character in UTF-8 is not cut in two.
std::string wire_name(const std::string& name) {
  std::string shortened = name.substr(0, name.find('\0'));
  if (shortened.size() <= kMaxNameBytes) return shortened;
  std::size_t end = kMaxNameBytes;
  while (end > 0 && is_continuation(shortened[end])) --end;
  shortened.resize(end);
  return shortened;
}

struct Plan {
  std::vector<ManifestEntry> entries;
  /// Nodes whose geometry has to be sent, and where they stand in `entries`.
  std::vector<const Node*> changed;
  std::vector<std::size_t> positions;
};

// Both models' nodes are in the order of their ids, and `last_entries` belongs to `last`.
Plan plan_update(const Model& model, const Model* last, const std::vector<ManifestEntry>& last_entries) {
  Plan plan;
  plan.entries.reserve(model.nodes.size());
  std::size_t before = 0;
  for (const auto& node : model.nodes) {
    ManifestEntry entry{node.id, wire_name(node.name), node.T_world_node, {}};
    while (last && before < last->nodes.size() && last->nodes[before].id < node.id) ++before;
    const bool known = last && before < last->nodes.size() && last->nodes[before].id == node.id;
    if (known && last->nodes[before].hash == node.hash) {
      entry.payload_hash = last_entries[before].payload_hash;
    } else {
      plan.changed.push_back(&node);
      plan.positions.push_back(plan.entries.size());
    }
    plan.entries.push_back(std::move(entry));
  }
  return plan;
}

Status check_model(const std::shared_ptr<const Model>& model) {
  if (!model) return fail("there is no model to publish");
  for (const auto& node : model->nodes) {
    if (!node.submesh) return fail(fmt::format("node {} has no geometry to publish", node.id));
  }
  const auto not_ascending = [](const Node& a, const Node& b) { return a.id >= b.id; };
  const auto it = std::adjacent_find(model->nodes.begin(), model->nodes.end(), not_ascending);
  if (it != model->nodes.end()) return fail(fmt::format("the model's nodes are not in order after node {}", it->id));
  return {};
}

}  // namespace

Publisher::Publisher(std::unique_ptr<SceneWriter> writer, std::uint64_t epoch)
    : writer_{std::move(writer)}, epoch_{epoch} {}

Result<PublishReport> Publisher::publish(const std::shared_ptr<const Model>& model, std::int64_t accepted_ns) {
  if (auto ok = check_model(model); !ok) return fail(ok.error());
  auto plan = plan_update(*model, last_.get(), entries_);
  PublishReport report;
  const Stopwatch encoding;
  auto encoded = encode_nodes(plan.changed, kEncodingThreads);
  if (!encoded) return fail(encoded.error());
  report.encode_ms = encoding.milliseconds();

  for (std::size_t i = 0; i < encoded->size(); ++i) {
    const Node& node = *plan.changed[i];
    auto& [bytes, hash] = (*encoded)[i];
    report.bytes += bytes.size();
    report.raw_bytes += node.submesh->raw_bytes();
    ++report.nodes_sent;
    const auto sent = writer_->write(NodePayload{node.id, epoch_, model->revision, hash, std::move(bytes)});
    if (!sent) return fail("publishing", sent.error());
    plan.entries[plan.positions[i]].payload_hash = hash;
  }
  Manifest manifest{epoch_, model->revision, accepted_ns, std::move(plan.entries)};
  if (auto sent = writer_->write(manifest); !sent) return fail("publishing", sent.error());
  const auto before = std::exchange(last_, model);
  entries_ = std::move(manifest.nodes);
  report.nodes_disposed = before ? dispose_gone(*before) : 0;
  return report;
}

// From here on the update is published: what the manifest does not name is gone for every client, so a node that cannot
// be taken off the network only costs late clients its bytes.
std::size_t Publisher::dispose_gone(const Model& before) {
  std::vector<NodeId> ids_before;
  std::vector<NodeId> ids_now;
  std::vector<NodeId> gone;
  for (const auto& node : before.nodes) ids_before.push_back(node.id);
  for (const auto& node : last_->nodes) ids_now.push_back(node.id);
  std::set_difference(ids_before.begin(), ids_before.end(), ids_now.begin(), ids_now.end(), std::back_inserter(gone));
  std::size_t disposed = 0;
  for (const NodeId id : gone) {
    if (const auto done = writer_->dispose(id); done) {
      ++disposed;
    } else {
      log_warning("{}", done.error().message);
    }
  }
  return disposed;
}

}  // namespace meshloop
