// The figures of common/codec/README.md. Run them with
//   test-common-codec --gtest_also_run_disabled_tests --gtest_filter='*Figures*'
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "common/base/clock.h"
#include "common/codec/mesh_codec.h"
#include "meshes.h"

namespace meshloop {
namespace {

void print_row(const char* name, const Submesh& mesh, int speed) {
  const Stopwatch encoding;
  const auto bytes = encode(mesh, {speed}).value();
  const double encode_ms = encoding.milliseconds();
  const Stopwatch decoding;
  const auto decoded = decode(bytes).value();
  const double decode_ms = decoding.milliseconds();
  ASSERT_EQ(decoded.triangles.size(), mesh.triangles.size());
  fmt::print("{:24} {:5} {:9} {:9} {:7.1f} {:9.0f} {:9.0f}\n", name, speed, mesh.triangles.size(), bytes.size(),
             static_cast<double>(mesh.raw_bytes()) / static_cast<double>(bytes.size()), encode_ms, decode_ms);
}

TEST(CodecFigures, DISABLED_DepthGrids) {
  fmt::print("{:24} {:>5} {:>9} {:>9} {:>7} {:>9} {:>9}\n", "mesh", "speed", "triangles", "bytes", "raw/x", "encode ms",
             "decode ms");
  const auto grid = test::depth_grid(640, 480);
  for (const int speed : {0, 1, 2, 5, 10}) print_row("640x480, 2 mm noise", grid, speed);
  print_row("640x480, strong texture", test::depth_grid(640, 480, {0.002f, 60, 4}), 2);
  print_row("640x480, no noise", test::depth_grid(640, 480, {0, 0, 0}), 2);
  auto plain = grid;
  plain.colors.clear();
  print_row("640x480, no colours", plain, 2);
  auto snapshot = snap_to_lattice(grid, 4);
  for (auto& color : snapshot.colors) {
    for (auto* channel : {&color.r, &color.g, &color.b})
      *channel = static_cast<std::uint8_t>(*channel / kCoarseColorStep * kCoarseColorStep);
  }
  print_row("640x480, as a snapshot", snapshot, 2);
  print_row("120x90, 2 mm noise", test::depth_grid(120, 90), 2);
}

}  // namespace
}  // namespace meshloop
