#pragma once
// The peer of an insertion: the Point Cloud Library's OrganizedFastMesh. Apart, since its headers take long to read.
#include <memory>

#include "common/geometry/camera.h"
#include "common/image/frames.h"

namespace meshloop {

/// A depth image as an organised, coloured point cloud, and its triangles.
class PclMesh {
 public:
  PclMesh();
  ~PclMesh();
  PclMesh(const PclMesh&) = delete;
  PclMesh& operator=(const PclMesh&) = delete;

  /// Points in the depth camera's frame; each has the colour of the pixel in its own place of `color`, without a
  /// look at visibility. NaN where nothing was measured.
  void set_points(const DepthImage& depth, const Camera& camera, const ColorImage& color);
  /// Triangles between neighbouring pixels, along the better of two diagonals (TRIANGLE_ADAPTIVE_CUT), no edge longer
  /// than `max_edge_m`. Returns how many.
  std::size_t triangulate(float max_edge_m);

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace meshloop
