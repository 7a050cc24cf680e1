#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <tuple>

#include "common/base/log.h"
#include "common/transport/scene_link.h"
#include "common/transport/scene_topics.h"
#include "common/transport/wire.h"

namespace meshloop {
namespace {

constexpr std::size_t kMostBytesATake = 64u << 20;

struct ReaderEntities {
  SceneTopics topics;
  Entity subscriber;
  Entity mesh_nodes;
  Entity manifests;
  Entity waitset;
};

Result<Entity> create_waitset(const SceneTopics& topics, const Entity& mesh_nodes, const Entity& manifests) {
  auto waitset = own(dds_create_waitset(topics.domain->participant()), "a waitset");
  if (!waitset) return waitset;
  for (const auto* reader : {&mesh_nodes, &manifests}) {
    // The condition goes with its reader.
    const auto condition = dds_create_readcondition(reader->get(), DDS_ANY_STATE);
    if (condition < 0 || dds_waitset_attach(waitset->get(), condition, 0) < 0)
      return fail("DDS refused a read condition");
  }
  return waitset;
}

Result<ReaderEntities> create_entities(const LinkOptions& options) {
  auto domain = Domain::join(options.domain, options.peers);
  if (!domain) return fail(domain.error());
  auto topics = create_topics(std::move(*domain));
  if (!topics) return fail(topics.error());
  auto subscriber = create_subscriber(*topics, options.scene);
  if (!subscriber) return fail(subscriber.error());
  auto mesh_nodes = create_reader(*subscriber, topics->mesh_nodes);
  if (!mesh_nodes) return fail(mesh_nodes.error());
  auto manifests = create_reader(*subscriber, topics->manifests);
  if (!manifests) return fail(manifests.error());
  auto waitset = create_waitset(*topics, *mesh_nodes, *manifests);
  if (!waitset) return fail(waitset.error());
  return ReaderEntities{std::move(*topics), std::move(*subscriber), std::move(*mesh_nodes), std::move(*manifests),
                        std::move(*waitset)};
}

// Calls `use` for each sample that the reader holds, until it returns false. Samples without data (a node was disposed
// of, or its station went away) say nothing that the manifest does not say better.
template <class Sample, class Use>
void take_each(const Entity& reader, Use use) {
  constexpr std::uint32_t kBatch = 16;
  bool more = true;
  while (more) {
    std::array<void*, kBatch> samples{};
    std::array<dds_sample_info_t, kBatch> infos;
    const auto count = dds_take(reader.get(), samples.data(), infos.data(), kBatch, kBatch);
    if (count <= 0) return;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      if (infos[i].valid_data) more = use(*static_cast<const Sample*>(samples[i])) && more;
    }
    dds_return_loan(reader.get(), samples.data(), count);
  }
}

bool is_newer(const Manifest& a, const std::optional<Manifest>& b) {
  return !b || std::tie(a.epoch, a.revision) > std::tie(b->epoch, b->revision);
}

class DdsSceneReader final : public SceneReader {
 public:
  DdsSceneReader(std::string scene, ReaderEntities entities)
      : scene_{std::move(scene)}, entities_{std::move(entities)} {}

  SceneSamples take(std::chrono::milliseconds longest_wait) override {
    dds_waitset_wait(entities_.waitset.get(), nullptr, 0,
                     std::max<dds_duration_t>(0, longest_wait.count()) * 1'000'000);
    SceneSamples taken;
    take_each<meshloop_wire_Manifest>(entities_.manifests, [&](const auto& sample) {
      auto manifest = accepted(from_wire(sample, scene_));
      if (manifest && is_newer(*manifest, taken.manifest)) taken.manifest = std::move(*manifest);
      return true;
    });
    std::size_t bytes = 0;
    take_each<meshloop_wire_MeshNode>(entities_.mesh_nodes, [&](const auto& sample) {
      if (auto payload = accepted(from_wire(sample, scene_))) {
        bytes += payload->bytes.size();
        taken.payloads.push_back(std::move(*payload));
      }
      return bytes < kMostBytesATake - 16 * kMaxPayloadBytes;
    });
    return taken;
  }

  [[nodiscard]] std::size_t rejected() const override { return rejected_; }

 private:
  template <class T>
  Result<T> accepted(Result<T> converted) {
    if (!converted) {
      const std::size_t count = ++rejected_;
      // Ever more rarely, so that a hostile sender does not fill the disk with our log.
      if (std::has_single_bit(count)) {
        log_warning("dropped a sample from the network ({} so far): {}", count, converted.error().message);
      }
    }
    return converted;
  }

  std::string scene_;
  ReaderEntities entities_;
  std::atomic<std::size_t> rejected_{0};
};

}  // namespace

Result<std::unique_ptr<SceneReader>> SceneReader::create(const LinkOptions& options) {
  if (auto ok = check_scene_name(options.scene); !ok) return fail(ok.error());
  auto entities = create_entities(options);
  if (!entities) return fail(entities.error());
  return std::make_unique<DdsSceneReader>(options.scene, std::move(*entities));
}

}  // namespace meshloop
