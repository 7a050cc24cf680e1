#include "server/capture/prefetching_source.h"

#include <utility>

namespace meshloop {
namespace {

constexpr std::size_t kFramesAhead = 3;

}  // namespace

PrefetchingSource::PrefetchingSource(std::unique_ptr<RgbdSource> source, WhenFull when_full)
    : source_{std::move(source)}, queue_{kFramesAhead, when_full}, thread_{[this] { read_all(); }} {}

PrefetchingSource::~PrefetchingSource() {
  queue_.close();
  thread_.join();
}

void PrefetchingSource::read_all() {
  for (bool more = true; more;) {
    auto frame = source_->next();
    const bool at_end = frame && !*frame;
    more = queue_.push(std::move(frame)) && !at_end;
  }
  queue_.close();
}

Result<std::optional<RgbdFrame>> PrefetchingSource::next() {
  auto frame = queue_.pop();
  if (!frame) return std::nullopt;
  return std::move(*frame);
}

}  // namespace meshloop
