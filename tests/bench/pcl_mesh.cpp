#include "pcl_mesh.h"

#include <pcl/PolygonMesh.h>
#include <pcl/filters/fast_bilateral.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/surface/organized_fast_mesh.h>

#include <limits>

namespace meshloop {

using Point = pcl::PointXYZRGB;

struct PclMesh::Data {
  pcl::PointCloud<Point>::Ptr cloud{new pcl::PointCloud<Point>};
  pcl::PolygonMesh mesh;
};

PclMesh::PclMesh() : data_{std::make_unique<Data>()} {}
PclMesh::~PclMesh() = default;

void PclMesh::set_points(const DepthImage& depth, const Camera& camera, const ColorImage& color) {
  auto& cloud = *data_->cloud;
  cloud.resize(static_cast<std::size_t>(depth.width()) * static_cast<std::size_t>(depth.height()));
  cloud.width = static_cast<std::uint32_t>(depth.width());
  cloud.height = static_cast<std::uint32_t>(depth.height());
  cloud.is_dense = false;
  const auto fx = static_cast<float>(camera.fx);
  const auto fy = static_cast<float>(camera.fy);
  const auto cx = static_cast<float>(camera.cx);
  const auto cy = static_cast<float>(camera.cy);
  for (int y = 0; y < depth.height(); ++y) {
    const int color_y = y * color.height() / depth.height();
    for (int x = 0; x < depth.width(); ++x) {
      Point& point = cloud.at(x, y);
      const float z = depth(x, y) > 0 ? depth(x, y) : std::numeric_limits<float>::quiet_NaN();
      point.x = (static_cast<float>(x) - cx) * z / fx;
      point.y = (static_cast<float>(y) - cy) * z / fy;
      point.z = z;
      const Rgb8& c = color(x * color.width() / depth.width(), color_y);
      point.r = c.r;
      point.g = c.g;
      point.b = c.b;
    }
  }
}

void PclMesh::smooth(float sigma_m) {
  pcl::FastBilateralFilter<Point> filter;
  filter.setInputCloud(data_->cloud);
  filter.setSigmaS(1.2F);
  filter.setSigmaR(sigma_m);
  const auto smoothed = pcl::make_shared<pcl::PointCloud<Point>>();
  filter.filter(*smoothed);
  data_->cloud = smoothed;
}

std::size_t PclMesh::triangulate(float max_edge_m) {
  pcl::OrganizedFastMesh<Point> mesher;
  mesher.setInputCloud(data_->cloud);
  mesher.setTrianglePixelSize(1);
  mesher.setTriangulationType(pcl::OrganizedFastMesh<Point>::TRIANGLE_ADAPTIVE_CUT);
  mesher.setMaxEdgeLength(max_edge_m);
  mesher.reconstruct(data_->mesh);
  return data_->mesh.polygons.size();
}

Submesh PclMesh::arrays() const {
  constexpr auto kUnused = std::numeric_limits<std::uint32_t>::max();
  const auto& cloud = *data_->cloud;
  std::vector<std::uint32_t> number(cloud.size(), kUnused);
  Submesh mesh;
  mesh.triangles.reserve(data_->mesh.polygons.size());
  for (const auto& polygon : data_->mesh.polygons) {
    Triangle triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto i = static_cast<std::size_t>(polygon.vertices[k]);
      if (number[i] == kUnused) {
        number[i] = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.emplace_back(cloud[i].getVector3fMap());
        mesh.colors.push_back({cloud[i].r, cloud[i].g, cloud[i].b});
      }
      triangle[k] = number[i];
    }
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

}  // namespace meshloop
