#include "device/receive/scene_receiver.h"

#include <mutex>
#include <thread>

namespace meshloop {
namespace {

// How long a stop may take when nothing arrives.
constexpr std::chrono::milliseconds kLongestWait{50};

class ReceivingThread final : public SceneReceiver {
 public:
  explicit ReceivingThread(std::unique_ptr<SceneReader> reader)
      : reader_{std::move(reader)}, thread_{[this](const std::stop_token& stop) { run(stop); }} {}

  [[nodiscard]] std::shared_ptr<const ReceivedModel> newest() const override {
    const std::scoped_lock lock{mutex_};
    return newest_;
  }

  [[nodiscard]] ReceiveCounts counts() const override {
    const std::scoped_lock lock{mutex_};
    auto counts = counts_;
    counts.rejected += reader_->rejected();
    return counts;
  }

 private:
  void run(const std::stop_token& stop) {
    ModelAssembler assembler;
    while (!stop.stop_requested()) {
      auto model = assembler.add(reader_->take(kLongestWait));
      const std::scoped_lock lock{mutex_};
      counts_ = assembler.counts();
      if (model) newest_ = std::move(model);
    }
  }

  std::unique_ptr<SceneReader> reader_;
  mutable std::mutex mutex_;
  std::shared_ptr<const ReceivedModel> newest_;
  ReceiveCounts counts_;
  std::jthread thread_;  // last, so that it ends first
};

}  // namespace

Result<std::unique_ptr<SceneReceiver>> SceneReceiver::start(const LinkOptions& options) {
  auto reader = SceneReader::create(options);
  if (!reader) return fail(reader.error());
  return std::make_unique<ReceivingThread>(std::move(*reader));
}

}  // namespace meshloop
