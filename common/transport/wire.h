#pragma once
// Plain structs <-> the C structs that idlc makes of proto/meshloop.idl. Pure functions.
#include <meshloop.h>

#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/transport/scene_link.h"

namespace meshloop {

/// Refuses a scene name that no partition and no sample could carry.
[[nodiscard]] Status check_scene_name(const std::string& scene);

/// A sample whose payload points into `payload`: valid while that lives. Refuses what a reader would drop.
[[nodiscard]] Result<meshloop_wire_MeshNode> to_wire(const NodePayload& payload, const std::string& scene);

/// A manifest as a sample, with the entries it points to. The sample moves with its owner.
struct WireManifest {
  std::vector<meshloop_wire_NodeEntry> entries;
  meshloop_wire_Manifest sample{};
};
[[nodiscard]] Result<WireManifest> to_wire(const Manifest& manifest, const std::string& scene);

/// Refuses samples of another schema version or scene, and what breaks a bound. A payload's hash is recomputed.
[[nodiscard]] Result<NodePayload> from_wire(const meshloop_wire_MeshNode& sample, const std::string& scene);
/// The nodes come back in the order of their ids.
[[nodiscard]] Result<Manifest> from_wire(const meshloop_wire_Manifest& sample, const std::string& scene);

}  // namespace meshloop
