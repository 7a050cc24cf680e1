#pragma once
#include <chrono>
#include <cstddef>

namespace meshloop {

/// Keeps a sender at a rate: a bucket that fills with `bytes_per_s` up to `burst_bytes` and from which each message
/// takes its size. Starts full, so that a first burst goes out at once. Thread-free; the time is the caller's.
class TokenBucket {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Both above zero.
  TokenBucket(double bytes_per_s, double burst_bytes, Time now);

  /// How long a message of this size has to wait from `now` on. A message larger than the bucket waits for a full one
  /// and leaves a debt that the next messages wait for.
  [[nodiscard]] std::chrono::nanoseconds wait_before(std::size_t bytes, Time now) const;
  /// The message was sent.
  void take(std::size_t bytes, Time now);

 private:
  [[nodiscard]] double level_at(Time now) const;

  double bytes_per_s_;
  double burst_bytes_;
  double level_;
  Time filled_at_;
};

}  // namespace meshloop
