#include "common/transport/scene_topics.h"

#include <meshloop.h>

#include "common/transport/scene_link.h"

namespace meshloop {
namespace {

struct DeleteQos {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, DeleteQos>;

Qos quality_of_both_ends() {
  Qos qos{dds_create_qos()};
  const auto longest_block = DDS_MSECS(static_cast<dds_duration_t>(kLongestWriteBlock.count()));
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, longest_block);
  dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
  return qos;
}

Qos partition_of(const std::string& scene) {
  Qos qos{dds_create_qos()};
  dds_qset_partition1(qos.get(), scene.c_str());
  return qos;
}

}  // namespace

Result<SceneTopics> create_topics(std::unique_ptr<Domain> domain) {
  const auto participant = domain->participant();
  auto nodes =
      own(dds_create_topic(participant, &meshloop_wire_MeshNode_desc, "MeshNode", nullptr, nullptr), "a topic");
  if (!nodes) return fail(nodes.error());
  auto manifests =
      own(dds_create_topic(participant, &meshloop_wire_Manifest_desc, "Manifest", nullptr, nullptr), "a topic");
  if (!manifests) return fail(manifests.error());
  return SceneTopics{std::move(domain), std::move(*nodes), std::move(*manifests)};
}

Result<Entity> create_publisher(const SceneTopics& topics, const std::string& scene) {
  const auto qos = partition_of(scene);
  return own(dds_create_publisher(topics.domain->participant(), qos.get(), nullptr), "a publisher");
}

Result<Entity> create_subscriber(const SceneTopics& topics, const std::string& scene) {
  const auto qos = partition_of(scene);
  return own(dds_create_subscriber(topics.domain->participant(), qos.get(), nullptr), "a subscriber");
}

Result<Entity> create_writer(const Entity& publisher, const Entity& topic) {
  const auto qos = quality_of_both_ends();
  dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, 1, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED,
                              DDS_LENGTH_UNLIMITED);
  // With the default, a station that goes away would take the whole scene from its clients.
  dds_qset_writer_data_lifecycle(qos.get(), false);
  return own(dds_create_writer(publisher.get(), topic.get(), qos.get(), nullptr), "a writer");
}

Result<Entity> create_reader(const Entity& subscriber, const Entity& topic) {
  const auto qos = quality_of_both_ends();
  return own(dds_create_reader(subscriber.get(), topic.get(), qos.get(), nullptr), "a reader");
}

}  // namespace meshloop
