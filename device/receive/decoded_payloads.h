#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>

#include "common/base/hash.h"
#include "common/mesh/model.h"

namespace meshloop {

/// Where a payload or manifest stands in the scene's history: first the station's start, then the revision.
struct Age {
  std::uint64_t epoch = 0;
  Revision revision = 0;

  auto operator<=>(const Age&) const = default;
};

/// Geometry that came out of a payload.
struct Decoded {
  std::shared_ptr<const Submesh> submesh;
  /// Of the submesh (a Node's hash), not of the payload.
  Hash content{};
  Age age;
  /// What decoding it took; not yet reported with a model.
  double decode_ms = 0;
};

/// Decoded payloads by the hash of their bytes, in bounded memory. What the newest manifest names stays; what no
/// manifest has named yet is pending.
class DecodedPayloads {
 public:
  explicit DecodedPayloads(std::size_t max_pending_bytes) : max_pending_bytes_{max_pending_bytes} {}

  /// Null when it is not there.
  [[nodiscard]] Decoded* find(const Hash& payload);
  /// `named`: whether the newest manifest names it. Pending ones push out the oldest pending ones.
  void put(const Hash& payload, Decoded decoded, bool named);
  /// A new manifest: forgets what it does not name, except payloads younger than itself, which wait for their manifest.
  void keep(const std::set<Hash>& named, Age age);

 private:
  struct Kept {
    Decoded decoded;
    std::size_t bytes = 0;
    /// Order of arrival while pending; 0 when named.
    std::uint64_t pending_since = 0;
  };
  void make_pending(const Hash& payload, Kept& kept);
  void end_pending(Kept& kept);
  void forget_beyond_limit();

  std::size_t max_pending_bytes_;
  std::size_t pending_bytes_ = 0;
  std::uint64_t arrivals_ = 0;
  std::map<Hash, Kept> kept_;
  std::map<std::uint64_t, Hash> pending_;
};

}  // namespace meshloop
