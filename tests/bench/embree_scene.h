#pragma once
// Depth and node images by ray casting: the peer that the comparison is measured against.
#include <embree3/rtcore.h>

#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

#include "common/geometry/camera.h"
#include "common/image/image.h"
#include "common/mesh/model.h"

namespace meshloop::bench {

/// Rays in packets of eight (4 x 2 pixels), marked coherent; one thread for each band of rows.
class EmbreeScene {
 public:
  EmbreeScene(const Model& model, unsigned threads) : threads_{threads}, device_{rtcNewDevice(nullptr)} {
    scene_ = rtcNewScene(device_);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
    for (const auto& node : model.nodes) add(node);
    rtcCommitScene(scene_);
  }
  ~EmbreeScene() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  /// From the world's origin. The picture's sides must be multiples of four and of two.
  void cast(const Camera& camera, DepthImage& depth, Image<std::uint32_t>& nodes) const {
    std::vector<std::jthread> workers;
    const int bands = static_cast<int>(threads_);
    for (int band = 0; band < bands; ++band) {
      const int from = camera.height / 2 * band / bands * 2;
      const int to = camera.height / 2 * (band + 1) / bands * 2;
      workers.emplace_back([&, from, to] { cast_rows(camera, from, to, depth, nodes); });
    }
  }

 private:
  void add(const Node& node) {
    const Submesh& submesh = *node.submesh;
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, submesh.positions.size()));
    for (const auto& p : submesh.positions) {
      const Eigen::Vector3f world = (node.T_world_node * p.cast<double>()).cast<float>();
      for (int axis = 0; axis < 3; ++axis) *vertices++ = world[axis];
    }
    auto* indices = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, submesh.triangles.size()));
    for (const auto& triangle : submesh.triangles) indices = std::copy(triangle.begin(), triangle.end(), indices);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene_, geometry, static_cast<unsigned>(node.id));
    rtcReleaseGeometry(geometry);
  }

  void cast_rows(const Camera& camera, int from, int to, DepthImage& depth, Image<std::uint32_t>& nodes) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    alignas(32) const int all[8] = {-1, -1, -1, -1, -1, -1, -1, -1};
    for (int v = from; v < to; v += 2) {
      for (int u = 0; u < camera.width; u += 4) {
        RTCRayHit8 packet{};
        for (int k = 0; k < 8; ++k) {
          packet.ray.dir_x[k] = static_cast<float>((u + k % 4 - camera.cx) / camera.fx);
          packet.ray.dir_y[k] = static_cast<float>((v + k / 4 - camera.cy) / camera.fy);
          packet.ray.dir_z[k] = 1;
          packet.ray.tnear[k] = 0.05F;
          packet.ray.tfar[k] = 50;
          packet.ray.mask[k] = ~0U;
          packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
        }
        rtcIntersect8(all, scene_, &context, &packet);
        for (int k = 0; k < 8; ++k) {
          const bool hit = packet.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID;
          depth(u + k % 4, v + k / 4) = hit ? packet.ray.tfar[k] : 0;
          nodes(u + k % 4, v + k / 4) = hit ? packet.hit.geomID[k] : 0;
        }
      }
    }
  }

  unsigned threads_;
  RTCDevice device_;
  RTCScene scene_ = nullptr;
};

}  // namespace meshloop::bench
