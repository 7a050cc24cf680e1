#pragma once
#include <memory>
#include <thread>

#include "common/base/bounded_queue.h"
#include "server/capture/rgbd_source.h"

namespace meshloop {

/// Reads another source on a thread of its own, a few frames ahead. Live sources drop the oldest frame when the reader
/// is slow; recordings wait. Errors come out in their place among the frames.
class PrefetchingSource : public RgbdSource {
 public:
  PrefetchingSource(std::unique_ptr<RgbdSource> source, WhenFull when_full);
  ~PrefetchingSource() override;

  [[nodiscard]] const Rig& rig() const override { return source_->rig(); }
  [[nodiscard]] const Rig& calibration() const override { return source_->calibration(); }
  Result<std::optional<RgbdFrame>> next() override;
  [[nodiscard]] std::optional<int> frame_count() const override { return source_->frame_count(); }
  [[nodiscard]] bool ready() const override { return !queue_.would_wait(); }

 private:
  void read_all();

  std::unique_ptr<RgbdSource> source_;
  BoundedQueue<Result<std::optional<RgbdFrame>>> queue_;
  std::thread thread_;
};

}  // namespace meshloop
