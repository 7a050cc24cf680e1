#include "common/transport/token_bucket.h"

#include <algorithm>
#include <cmath>

namespace meshloop {

TokenBucket::TokenBucket(double bytes_per_s, double burst_bytes, Time now)
    : bytes_per_s_{bytes_per_s}, burst_bytes_{burst_bytes}, level_{burst_bytes}, filled_at_{now} {}

double TokenBucket::level_at(Time now) const {
  const double elapsed_s = std::chrono::duration<double>(now - filled_at_).count();
  return std::min(burst_bytes_, level_ + std::max(0.0, elapsed_s) * bytes_per_s_);
}

std::chrono::nanoseconds TokenBucket::wait_before(std::size_t bytes, Time now) const {
  const double needed = std::min(static_cast<double>(bytes), burst_bytes_);
  const double missing = needed - level_at(now);
  if (missing <= 0) return std::chrono::nanoseconds{0};
  return std::chrono::nanoseconds{static_cast<std::int64_t>(std::ceil(missing / bytes_per_s_ * 1e9))};
}

void TokenBucket::take(std::size_t bytes, Time now) {
  level_ = level_at(now) - static_cast<double>(bytes);
  filled_at_ = now;
}

}  // namespace meshloop
