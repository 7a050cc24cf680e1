#pragma once
// The DDS entities of one scene: topics with our quality of service, and the ends made of them.
#include <memory>
#include <string>

#include "common/transport/domain.h"
#include "common/transport/entity.h"

namespace meshloop {

/// A publisher or subscriber in the scene's partition, with the scene's topics. Deleted in the reverse order of
/// creation.
struct SceneTopics {
  std::unique_ptr<Domain> domain;
  Entity mesh_nodes;
  Entity manifests;
};

[[nodiscard]] Result<SceneTopics> create_topics(std::unique_ptr<Domain> domain);

[[nodiscard]] Result<Entity> create_publisher(const SceneTopics& topics, const std::string& scene);
[[nodiscard]] Result<Entity> create_subscriber(const SceneTopics& topics, const std::string& scene);

/// RELIABLE, TRANSIENT_LOCAL, KEEP_LAST 1: readers that come late get the newest sample of every node.
[[nodiscard]] Result<Entity> create_writer(const Entity& publisher, const Entity& topic);
[[nodiscard]] Result<Entity> create_reader(const Entity& subscriber, const Entity& topic);

}  // namespace meshloop
