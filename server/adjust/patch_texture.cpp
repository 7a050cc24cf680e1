#include "server/adjust/patch_texture.h"

#include <optional>
#include <utility>
#include <vector>

#include "common/image/jpeg_codec.h"

namespace meshloop::adjust {
namespace {

constexpr Rgb8 kGrey{128, 128, 128};

/// Colours of a window's pixels, known or not yet.
class Painting {
 public:
  Painting(int width, int height) : picture_{width, height, kGrey}, state_(picture_.size(), State::beside) {}

  void add(std::uint32_t pixel, const std::optional<Rgb8>& color) {
    state_[pixel] = color ? State::known : State::wanted;
    if (!color) return;
    picture_.pixels()[pixel] = *color;
    known_.push_back(pixel);
  }

  /// Breadth first from all known pixels at once: pixels of the patch, then those beside it too.
  ColorImage finish() && {
    spread(State::wanted);
    spread(State::beside);
    return std::move(picture_);
  }

 private:
  enum class State : std::uint8_t { beside, wanted, known };

  /// Pixels that are still unknown after the patch's own were reached hang together with none of them: they are taken
  /// together with what lies beside.
  void spread(State reached) {
    if (reached == State::beside) {
      for (auto& state : state_) state = state == State::wanted ? State::beside : state;
    }
    std::vector<std::uint32_t> queue = known_;
    for (std::size_t head = 0; head < queue.size(); ++head) {
      const int x = static_cast<int>(queue[head]) % picture_.width();
      const int y = static_cast<int>(queue[head]) / picture_.width();
      for (int k = 0; k < 9; ++k) {
        const int nx = x + k % 3 - 1;
        const int ny = y + k / 3 - 1;
        if (nx < 0 || ny < 0 || nx >= picture_.width() || ny >= picture_.height()) continue;
        const auto next = static_cast<std::uint32_t>(ny * picture_.width() + nx);
        if (state_[next] != reached) continue;
        state_[next] = State::known;
        picture_.pixels()[next] = picture_.pixels()[queue[head]];
        queue.push_back(next);
      }
    }
    known_ = std::move(queue);
  }

  ColorImage picture_;
  std::vector<State> state_;
  std::vector<std::uint32_t> known_;
};

ColorImage paint(const DepthGrid& grid, std::span<const std::uint32_t> pixels, const Camera& camera,
                 const ColorLookup& lookup) {
  const int w = grid.window.width();
  Painting painting{w, grid.window.height()};
  for (const auto pixel : pixels) {
    // What was not measured may not be what the colour camera sees there.
    if (grid.role[pixel] == Role::gap) {
      painting.add(pixel, std::nullopt);
      continue;
    }
    const int u = grid.window.x0 + static_cast<int>(pixel) % w;
    const int v = grid.window.y0 + static_cast<int>(pixel) / w;
    const Eigen::Vector3d p = camera.back_project(u, v, static_cast<double>(grid.z[pixel]));
    painting.add(pixel, lookup.texel_of(p.cast<float>(), grid.sigma[pixel]));
  }
  return std::move(painting).finish();
}

TextureProjection projection_of(const Window& window, const PlacedCamera& placed) {
  const Camera& camera = placed.camera;
  Eigen::Matrix3d K;
  K << camera.fx, 0, camera.cx - window.x0, 0, camera.fy, camera.cy - window.y0, 0, 0, 1;
  return (K * placed.T_camera_world.matrix().topRows<3>()).cast<float>();
}

}  // namespace

std::shared_ptr<const ProjectedTexture> make_patch_texture(const DepthGrid& grid, std::span<const std::uint32_t> pixels,
                                                           const PlacedCamera& placed, const ColorLookup& lookup) {
  auto jpeg = encode_jpeg(paint(grid, pixels, placed.camera, lookup), kTextureQuality);
  if (!jpeg) return nullptr;
  auto texture = make_projected_texture(std::move(*jpeg), projection_of(grid.window, placed));
  return texture ? std::move(*texture) : nullptr;
}

}  // namespace meshloop::adjust
