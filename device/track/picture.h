#pragma once
#include "common/image/image.h"

namespace meshloop {

/// One camera picture in the forms that its readers want.
struct Picture {
  explicit Picture(const ColorImage& color);

  GreyImage grey;
  /// local_contrast of `grey`.
  GreyImage contrast;
  /// Lightly blurred.
  GreyImage smooth;
};

}  // namespace meshloop
