#include "device/draw/presenter.h"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "common/image/image_file.h"

namespace meshloop {

OffscreenPresenter::OffscreenPresenter(OffscreenOptions options) : options_{std::move(options)} {}

Result<std::unique_ptr<OffscreenPresenter>> OffscreenPresenter::create(const OffscreenOptions& options) {
  if (options.every_nth < 1) {
    return fail(fmt::format("every {}th picture makes no sense: give 1 or more", options.every_nth), ErrorKind::usage);
  }
  std::error_code problem;
  std::filesystem::create_directories(options.folder, problem);
  if (problem || !std::filesystem::is_directory(options.folder, problem)) {
    return fail(fmt::format("the folder '{}' for the pictures cannot be made: {}", options.folder.string(),
                            problem ? problem.message() : std::string{"a file of that name is there"}));
  }
  return std::unique_ptr<OffscreenPresenter>(new OffscreenPresenter(options));
}

Status OffscreenPresenter::show(const ColorImage& picture) {
  const bool kept = keeps_next();
  const int position = shown_++;
  if (!kept) return {};
  return write_png(options_.folder / fmt::format("{:06}.png", position), picture);
}

}  // namespace meshloop
