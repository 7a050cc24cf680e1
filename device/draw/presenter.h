#pragma once
// Where the drawn pictures go. Each presenter is one pair of files in this folder.
#include <filesystem>
#include <memory>

#include "common/base/result.h"
#include "common/image/image.h"

namespace meshloop {

class Presenter {
 public:
  virtual ~Presenter() = default;
  /// Shows one picture. An error says that this and later pictures cannot be shown.
  [[nodiscard]] virtual Status show(const ColorImage& picture) = 0;
};

struct OffscreenOptions {
  std::filesystem::path folder;
  /// Of n pictures the first is written; 1 writes all. The others are counted only.
  int every_nth = 1;
};

/// Writes NNNNNN.png (the picture's position, from 0) into a folder, which is made when it is not there.
class OffscreenPresenter final : public Presenter {
 public:
  /// Refuses a folder that cannot be made and every_nth below 1.
  [[nodiscard]] static Result<std::unique_ptr<OffscreenPresenter>> create(const OffscreenOptions& options);
  [[nodiscard]] Status show(const ColorImage& picture) override;
  /// Whether the next picture is one that is written; one that is not can be skipped, and need not be drawn.
  [[nodiscard]] bool keeps_next() const { return shown_ % options_.every_nth == 0; }
  void skip() { ++shown_; }

 private:
  explicit OffscreenPresenter(OffscreenOptions options);
  OffscreenOptions options_;
  int shown_ = 0;
};

}  // namespace meshloop
