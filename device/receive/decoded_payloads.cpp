#include "device/receive/decoded_payloads.h"

#include <utility>

namespace meshloop {
namespace {

/// What it takes in memory here: a texture waits as its JPEG.
std::size_t bytes_of(const Submesh& submesh) {
  return submesh.geometry_bytes() + (submesh.texture ? submesh.texture->jpeg.size() : 0);
}

}  // namespace

Decoded* DecodedPayloads::find(const Hash& payload) {
  const auto it = kept_.find(payload);
  return it == kept_.end() ? nullptr : &it->second.decoded;
}

void DecodedPayloads::put(const Hash& payload, Decoded decoded, bool named) {
  const std::size_t bytes = bytes_of(*decoded.submesh);
  const auto [it, added] = kept_.try_emplace(payload, Kept{std::move(decoded), bytes, 0});
  if (!added || named) return;
  make_pending(payload, it->second);
  forget_beyond_limit();
}

void DecodedPayloads::make_pending(const Hash& payload, Kept& kept) {
  kept.pending_since = ++arrivals_;
  pending_.emplace(kept.pending_since, payload);
  pending_bytes_ += kept.bytes;
}

void DecodedPayloads::end_pending(Kept& kept) {
  pending_.erase(std::exchange(kept.pending_since, 0));
  pending_bytes_ -= kept.bytes;
}

void DecodedPayloads::forget_beyond_limit() {
  while (pending_bytes_ > max_pending_bytes_) {
    const auto oldest = kept_.find(pending_.begin()->second);
    end_pending(oldest->second);
    kept_.erase(oldest);
  }
}

void DecodedPayloads::keep(const std::set<Hash>& named, Age age) {
  for (auto it = kept_.begin(); it != kept_.end();) {
    auto& [payload, kept] = *it;
    const bool is_named = named.contains(payload);
    const bool is_pending = !is_named && kept.decoded.age > age;
    if (kept.pending_since != 0 && !is_pending) end_pending(kept);
    if (kept.pending_since == 0 && is_pending) make_pending(payload, kept);
    it = is_named || is_pending ? std::next(it) : kept_.erase(it);
  }
  forget_beyond_limit();
}

}  // namespace meshloop
