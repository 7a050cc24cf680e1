// Payloads from the network, with and without a texture or offsets at the border: an error or a valid mesh on the
// lattice, whose picture can be decoded; never a crash.
// Rooms: common/codec common/image
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <random>
#include <span>
#include <utility>

#include "common/codec/border_offsets.h"
#include "common/codec/mesh_codec.h"
#include "common/image/jpeg_codec.h"
#include "common/mesh/lattice.h"

using meshloop::Submesh;

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

/// Enough room for real payloads, little enough for many runs a second.
constexpr meshloop::DecodeLimits kLimits{1u << 20, 100'000, 200'000};

Submesh bumpy_grid(std::uint32_t cells, bool colored) {
  Submesh mesh;
  for (std::uint32_t y = 0; y <= cells; ++y) {
    for (std::uint32_t x = 0; x <= cells; ++x) {
      const auto height = static_cast<float>((x * x + 3 * y) % 7);
      mesh.positions.push_back(Eigen::Vector3f(static_cast<float>(x) * 5, static_cast<float>(y) * 4, height) *
                               meshloop::kLatticeSpacing_m);
      if (colored) mesh.colors.push_back({static_cast<std::uint8_t>(x * 9), static_cast<std::uint8_t>(y * 7), 40});
    }
  }
  const std::uint32_t row = cells + 1;
  for (std::uint32_t y = 0; y < cells; ++y) {
    for (std::uint32_t x = 0; x < cells; ++x) {
      const std::uint32_t a = y * row + x;
      if ((x + y) % 11 != 0) mesh.triangles.push_back({a, a + 1, a + row});  // holes and split vertices
      mesh.triangles.push_back({a + 1, a + row + 1, a + row});
    }
  }
  return mesh;
}

/// On a coarse lattice, but for its border.
Submesh joined(Submesh grid) {
  const auto is_border = meshloop::border_vertices(grid.triangles, grid.positions.size());
  std::vector<std::uint32_t> border;
  for (std::uint32_t i = 0; i < is_border.size(); ++i) {
    if (is_border[i]) border.push_back(i);
  }
  return meshloop::snap_to_lattice(std::move(grid), 2, border);
}

/// A picture seen along z, from a metre before the grid.
std::shared_ptr<const meshloop::ProjectedTexture> picture(std::uint32_t side, unsigned seed) {
  meshloop::ColorImage image{static_cast<int>(side), static_cast<int>(side)};
  std::minstd_rand random{seed};
  for (auto& pixel : image.pixels()) pixel = {static_cast<std::uint8_t>(random()), 90, 40};
  meshloop::TextureProjection projection;
  projection << 50, 0, 5, 5, 0, 50, 5, 5, 0, 0, 1, 1;
  return meshloop::make_projected_texture(meshloop::encode_jpeg(image, 60).value(), projection).value();
}

/// A real payload, so that mutation starts from bytes that reach every part of the decoder.
std::vector<std::byte> real_payload(unsigned seed) {
  std::minstd_rand random{seed};
  const auto cells = static_cast<std::uint32_t>(2 + random() % 26);
  const int speeds[] = {0, 2, 5, 10};
  const auto kind = random() % 4;
  Submesh grid = bumpy_grid(cells, kind == 0 || kind == 3);
  if (kind == 3) grid = joined(std::move(grid));
  if (kind == 1) grid.texture = picture(1 + static_cast<std::uint32_t>(random() % 24), seed);
  return meshloop::encode(grid, {speeds[random() % 4]}).value();
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  if (size < 16 || seed % 8 == 0) {
    const auto payload = real_payload(seed);
    if (payload.size() <= max_size) {
      std::memcpy(data, payload.data(), payload.size());
      size = payload.size();
    }
  }
  return LLVMFuzzerMutate(data, size, max_size);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto mesh = meshloop::decode(std::as_bytes(std::span{data, size}), kLimits);
  if (mesh && mesh->positions.size() > kLimits.max_vertices) std::abort();
  if (mesh && mesh->triangles.size() > kLimits.max_triangles) std::abort();
  if (mesh && (!meshloop::validate(*mesh) || !meshloop::is_on_lattice(*mesh))) std::abort();
  if (mesh && !meshloop::vertex_colors(*mesh)) std::abort();
  return 0;
}
