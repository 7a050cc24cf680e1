#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "common/transport/scene_link.h"
#include "common/transport/scene_topics.h"
#include "common/transport/token_bucket.h"
#include "common/transport/wire.h"

namespace meshloop {
namespace {

constexpr double kLowestRate = 10e3;

struct WriterEntities {
  SceneTopics topics;
  Entity publisher;
  Entity mesh_nodes;
  Entity manifests;
};

Result<WriterEntities> create_entities(const LinkOptions& options) {
  auto domain = Domain::join(options.domain, options.peers);
  if (!domain) return fail(domain.error());
  auto topics = create_topics(std::move(*domain));
  if (!topics) return fail(topics.error());
  auto publisher = create_publisher(*topics, options.scene);
  if (!publisher) return fail(publisher.error());
  auto mesh_nodes = create_writer(*publisher, topics->mesh_nodes);
  if (!mesh_nodes) return fail(mesh_nodes.error());
  auto manifests = create_writer(*publisher, topics->manifests);
  if (!manifests) return fail(manifests.error());
  return WriterEntities{std::move(*topics), std::move(*publisher), std::move(*mesh_nodes), std::move(*manifests)};
}

Status check_written(dds_return_t code, const std::string& what) {
  if (code >= 0) return {};
  if (code == DDS_RETCODE_TIMEOUT) {
    return fail(
        fmt::format("{} was not sent: a reader does not keep up, or went away a moment ago; publish again", what));
  }
  return fail(fmt::format("{} was not sent: DDS says '{}'", what, dds_strretcode(code)));
}

class DdsSceneWriter final : public SceneWriter {
 public:
  DdsSceneWriter(std::string scene, double bytes_per_s, WriterEntities entities)
      : scene_{std::move(scene)},
        entities_{std::move(entities)},
        bucket_{bytes_per_s, static_cast<double>(kMaxPayloadBytes), std::chrono::steady_clock::now()} {}

  Status write(const NodePayload& payload) override {
    const auto sample = to_wire(payload, scene_);
    if (!sample) return fail(sample.error());
    pace(payload.bytes.size());
    return check_written(dds_write(entities_.mesh_nodes.get(), &*sample), fmt::format("node {}", payload.id));
  }

  Status write(const Manifest& manifest) override {
    const auto wire = to_wire(manifest, scene_);
    if (!wire) return fail(wire.error());
    pace(wire->entries.size() * sizeof(meshloop_wire_NodeEntry));
    return check_written(dds_write(entities_.manifests.get(), &wire->sample),
                         fmt::format("the manifest of revision {}", manifest.revision));
  }

  Status dispose(NodeId id) override {
    const auto sample = to_wire(NodePayload{id, 0, 0, {}, {std::byte{0}}}, scene_);
    if (!sample) return fail(sample.error());
    const auto what = fmt::format("the removal of node {}", id);
    if (auto ok = check_written(dds_dispose(entities_.mesh_nodes.get(), &*sample), what); !ok) return ok;
    // Unregistered too, or the writer would keep something of every node that ever was.
    return check_written(dds_unregister_instance(entities_.mesh_nodes.get(), &*sample), what);
  }

  [[nodiscard]] int readers() const override {
    return static_cast<int>(std::min(matched(entities_.mesh_nodes), matched(entities_.manifests)));
  }

 private:
  static std::uint32_t matched(const Entity& writer) {
    dds_publication_matched_status_t status{};
    return dds_get_publication_matched_status(writer.get(), &status) < 0 ? 0 : status.current_count;
  }

  // Without readers nothing is sent, so nothing has to wait.
  void pace(std::size_t bytes) {
    if (matched(entities_.mesh_nodes) == 0) return;
    const auto wait = bucket_.wait_before(bytes, std::chrono::steady_clock::now());
    if (wait.count() > 0) std::this_thread::sleep_for(wait);
    bucket_.take(bytes, std::chrono::steady_clock::now());
  }

  std::string scene_;
  WriterEntities entities_;
  TokenBucket bucket_;
};

}  // namespace

Result<std::unique_ptr<SceneWriter>> SceneWriter::create(const LinkOptions& options) {
  if (auto ok = check_scene_name(options.scene); !ok) return fail(ok.error());
  if (!(options.bytes_per_s >= kLowestRate && options.bytes_per_s < 1e12)) {
    return fail(fmt::format("{} bytes a second is no rate to send at: choose 10,000 or more", options.bytes_per_s),
                ErrorKind::usage);
  }
  auto entities = create_entities(options);
  if (!entities) return fail(entities.error());
  return std::make_unique<DdsSceneWriter>(options.scene, options.bytes_per_s, std::move(*entities));
}

}  // namespace meshloop
