#pragma once
// Links over the real network stack of this machine. Each process has a domain of its own, so that tests run in
// parallel.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <thread>

#include "common/transport/scene_link.h"

namespace meshloop::test {

using std::chrono::milliseconds;

/// Domains above 100 have ports that the system also hands out to others.
inline unsigned domain_of_process(pid_t pid = getpid()) {
  return 1 + static_cast<unsigned>(pid) % 100;
}

inline LinkOptions options_of(const std::string& scene, unsigned domain = domain_of_process()) {
  LinkOptions options;
  options.scene = scene;
  options.domain = domain;
  return options;
}

/// Bytes that differ between seeds.
inline std::vector<std::byte> bytes_of(std::size_t size, unsigned seed) {
  std::vector<std::byte> bytes(size);
  for (auto& byte : bytes) {
    seed = seed * 1664525u + 1013904223u;
    byte = static_cast<std::byte>(seed >> 24);
  }
  return bytes;
}

inline NodePayload payload_of(NodeId id, std::uint64_t epoch, Revision revision, std::size_t size = 1000) {
  NodePayload payload{id, epoch, revision, {}, bytes_of(size, static_cast<unsigned>(id * 1000 + revision))};
  payload.hash = hash_of(payload.bytes);
  return payload;
}

inline Manifest manifest_of(std::uint64_t epoch, Revision revision, const std::vector<NodePayload>& nodes) {
  Manifest manifest{epoch, revision, 42, {}};
  for (const auto& node : nodes) {
    manifest.nodes.push_back({node.id, fmt::format("node {}", node.id), Pose::Identity(), node.hash});
  }
  return manifest;
}

/// What a reader has seen so far: the newest payload of each node, and the newest manifest.
struct Seen {
  std::map<NodeId, NodePayload> payloads;
  std::optional<Manifest> manifest;
};

/// Takes samples until `enough`; false when that did not happen in time.
inline bool take_until(SceneReader& reader, Seen& seen, const std::function<bool(const Seen&)>& enough,
                       milliseconds longest = milliseconds{15'000}) {
  const auto end = std::chrono::steady_clock::now() + longest;
  while (!enough(seen)) {
    if (std::chrono::steady_clock::now() > end) return false;
    auto taken = reader.take(milliseconds{50});
    for (auto& payload : taken.payloads) seen.payloads[payload.id] = std::move(payload);
    if (taken.manifest) seen.manifest = std::move(taken.manifest);
  }
  return true;
}

inline bool wait_until(const std::function<bool()>& reached, milliseconds longest = milliseconds{15'000}) {
  const auto end = std::chrono::steady_clock::now() + longest;
  while (!reached()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(milliseconds{5});
  }
  return true;
}

template <class T>
T must(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

}  // namespace meshloop::test
