#pragma once
// The peer of an insertion: the Point Cloud Library's OrganizedFastMesh, and what it takes to make a patch with it.
// Apart, since its headers take long to read.
#include <memory>

#include "common/geometry/camera.h"
#include "common/image/frames.h"
#include "common/mesh/submesh.h"

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
  /// PCL's fast bilateral filter over the points' depths: 1.2 pixels, and `sigma_m` of depth.
  void smooth(float sigma_m);
  /// Triangles between neighbouring pixels, along the better of two diagonals (TRIANGLE_ADAPTIVE_CUT), no edge longer
  /// than `max_edge_m`. Returns how many.
  std::size_t triangulate(float max_edge_m);
  /// The points that the triangles use, their colours and the triangles as arrays that can go to a GPU.
  [[nodiscard]] Submesh arrays() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace meshloop
