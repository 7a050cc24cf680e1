// Makes pictures to look at, not run by default:
//   MESHLOOP_PICTURES=DIR test-device-draw --gtest_also_run_disabled_tests --gtest_filter='*DemoPicture*'
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "common/base/clock.h"
#include "common/simulation/scene.h"
#include "common/simulation/sensor.h"
#include "device/draw/ar_renderer.h"
#include "device/draw/demo_object.h"
#include "device/draw/presenter.h"

namespace meshloop {
namespace {

TEST(DemoPicture, DISABLED_LighthouseOnTheSideboard) {
  const char* folder = std::getenv("MESHLOOP_PICTURES");
  if (folder == nullptr) GTEST_SKIP() << "set MESHLOOP_PICTURES to a folder";
  auto context = GpuContext::create_headless();
  auto renderer = ArRenderer::create(**context);
  auto presenter = OffscreenPresenter::create({folder, 1});
  ASSERT_TRUE(renderer && presenter);
  const auto scene = simulation::make_demo_scene(1);
  Model model;
  for (auto& mesh : simulation::tessellate(scene, false, 0.02)) {
    model.nodes.push_back(make_node(model.nodes.size() + 1, mesh.name, std::move(mesh.submesh)));
  }
  std::vector<VirtualObject> objects(1);
  objects[0].submesh = std::make_shared<const Submesh>(make_lighthouse());
  objects[0].T_world_object.translation() = Eigen::Vector3d{0.02, -0.13, 0};
  const Camera camera{640, 480, 525, 525, 319.5, 239.5, {}};
  std::vector<double> times_ms;
  for (const double angle_deg : {-100.0, -60.0, -20.0, 40.0, 100.0, 200.0}) {
    const double angle = angle_deg * std::numbers::pi / 180;
    ArFrame frame;
    frame.camera = camera;
    frame.T_camera_world =
        look_at({0.9 * std::cos(angle), 0.9 * std::sin(angle), 0.45}, {0, 0, 0.06}, Eigen::Vector3d::UnitZ()).inverse();
    const ColorImage seen = simulation::cast_color(scene, camera, frame.T_camera_world, 3);
    frame.camera_image = &seen;
    frame.tracked = true;
    frame.model = &model;
    frame.objects = &objects;
    frame.hud = {4, "tracking", 28};
    const Stopwatch watch;
    const ColorImage picture = (*renderer)->draw(frame);
    times_ms.push_back(watch.milliseconds());
    ASSERT_TRUE((*presenter)->show(picture));
  }
  std::printf("%zu triangles, %zu of the object:", model.triangle_count(), objects[0].submesh->triangles.size());
  for (const double ms : times_ms) std::printf(" %.0f", ms);
  std::printf(" ms\n");
}

}  // namespace
}  // namespace meshloop
