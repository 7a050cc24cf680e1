#pragma once
// Values as blobs: little-endian, without gaps.
#include <bit>
#include <cstddef>
#include <cstring>
#include <optional>
#include <span>
#include <vector>

#include "common/geometry/pose.h"

namespace meshloop {

static_assert(std::endian::native == std::endian::little, "blobs are written as they lie in memory");

template <class T>
[[nodiscard]] std::span<const std::byte> blob_of(const std::vector<T>& values) {
  return std::as_bytes(std::span{values});
}

/// Nothing when the bytes are not a whole number of elements.
template <class T>
[[nodiscard]] std::optional<std::vector<T>> from_blob(std::span<const std::byte> blob) {
  if (blob.size() % sizeof(T) != 0) return std::nullopt;
  std::vector<T> values(blob.size() / sizeof(T));
  if (!blob.empty()) std::memcpy(static_cast<void*>(values.data()), blob.data(), blob.size());
  return values;
}

/// The 4x4 matrix, column by column, 16 float64.
[[nodiscard]] inline std::vector<double> pose_values(const Pose& pose) {
  return {pose.matrix().data(), pose.matrix().data() + 16};
}

/// Nothing when it is not a rigid transform.
[[nodiscard]] inline std::optional<Pose> pose_from_blob(std::span<const std::byte> blob) {
  if (blob.size() != 16 * sizeof(double)) return std::nullopt;
  Pose pose;
  std::memcpy(pose.matrix().data(), blob.data(), blob.size());
  const bool affine = pose.matrix().row(3) == Eigen::RowVector4d(0, 0, 0, 1);
  return affine && is_rigid(pose) ? std::optional{pose} : std::nullopt;
}

}  // namespace meshloop
