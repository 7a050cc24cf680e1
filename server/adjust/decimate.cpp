#include "server/adjust/decimate.h"

#include <meshoptimizer.h>

namespace meshloop::adjust {

namespace {

float brightness(const Rgb8& color) {
  return 0.299f * static_cast<float>(color.r) + 0.587f * static_cast<float>(color.g) +
         0.114f * static_cast<float>(color.b);
}

/// The surface with its brightness as a relief: where the form is flat and the colour is not, it is not flat.
std::vector<Eigen::Vector3f> relief_of(const Submesh& submesh, float m_per_level) {
  std::vector<Eigen::Vector3f> relief = submesh.positions;
  if (!submesh.has_colors()) return relief;
  const auto normals = vertex_normals(submesh);
  for (std::size_t i = 0; i < relief.size(); ++i) relief[i] += m_per_level * brightness(submesh.colors[i]) * normals[i];
  return relief;
}

}  // namespace

Submesh decimate(const Submesh& submesh, double error_m, double error_levels, Border border) {
  if (submesh.triangles.empty()) return submesh;
  const auto relief = relief_of(submesh, static_cast<float>(error_m / error_levels));
  const float* positions = relief.front().data();
  const float scale = meshopt_simplifyScale(positions, relief.size(), sizeof(Eigen::Vector3f));
  if (!(scale > 0)) return submesh;
  Submesh result = submesh;
  const std::size_t kept =
      meshopt_simplify(result.triangles.front().data(), submesh.triangles.front().data(), 3 * submesh.triangles.size(),
                       positions, relief.size(), sizeof(Eigen::Vector3f), 0, static_cast<float>(error_m) / scale,
                       border == Border::kept ? meshopt_SimplifyLockBorder : 0, nullptr);
  result.triangles.resize(kept / 3);
  const std::vector<bool> all(result.triangles.size(), true);
  return keep_triangles(std::move(result), all);
}

}  // namespace meshloop::adjust
