#include "server/show/carry.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "common/gpu/gl_objects.h"
#include "common/gpu/projection.h"
#include "server/show/surface_blocks.h"
#include "shaders/shaders.h"

namespace meshloop::show {
namespace {

constexpr GLint kClipFromPlace = 0;
constexpr GLint kDepthWidth = 1;
constexpr GLuint kPlace = 0;
constexpr GLuint kBlock = 1;

constexpr double kNear_m = 0.02;
constexpr double kFar_m = 60;
// In pixels of the depth image: so far a pixel may be displaced in the colour image by the plane of its block, and so
// far each block reaches beyond its own pixels, which closes the gaps between blocks of different size.
constexpr double kDisplacement_px = 0.2;
constexpr float kMargin_px = 0.2f;

struct Vertex {
  float u;
  float v;
  float inverse_depth;
  GLuint block;
};
static_assert(sizeof(Vertex) == 16);

struct Targets {
  int width;
  int height;
  Texture source;
  Texture z_buffer;
  Framebuffer framebuffer;

  Targets(int wide, int high)
      : width{wide},
        height{high},
        source{make_texture(GL_R32UI, wide, high)},
        z_buffer{make_texture(GL_DEPTH_COMPONENT32F, wide, high)} {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, source.name(), 0);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, z_buffer.name(), 0);
  }
};

// From (u, v, 1, 1/z) of the depth image to the colour camera's clip space. A point is z (x, y, 1) with (x, y) linear
// in (u, v); homogeneous coordinates leave out the factor z.
Eigen::Matrix4f clip_from_place(const Rig& rig) {
  Eigen::Matrix4d ray_from_place = Eigen::Matrix4d::Identity();
  ray_from_place.topLeftCorner<2, 3>() << 1 / rig.depth.fx, 0, -rig.depth.cx / rig.depth.fx, 0, 1 / rig.depth.fy,
      -rig.depth.cy / rig.depth.fy;
  const Eigen::Matrix4d T_color_depth = rig.T_depth_color.inverse().matrix();
  return (clip_from_camera(rig.color, kNear_m, kFar_m) * T_color_depth * ray_from_place).cast<float>();
}

BlockRules rules_of(const Rig& rig) {
  // By this much an inverse depth moves a pixel: its parallax, f |t|. Seen by eyes in one place it moves none.
  const double parallax = std::max(rig.depth.fx, rig.depth.fy) * rig.T_depth_color.translation().norm();
  return {rig.depth, rig.sensor, static_cast<float>(kDisplacement_px / std::max(parallax, 1e-6))};
}

void append(std::vector<Vertex>& vertices, const Block& block) {
  const auto bits =
      static_cast<GLuint>(block.x) | static_cast<GLuint>(block.y) << 14 | static_cast<GLuint>(block.size) << 28;
  const float left = static_cast<float>(block.x) - 0.5f - kMargin_px;
  const float top = static_cast<float>(block.y) - 0.5f - kMargin_px;
  const float right = static_cast<float>(block.x + block.size) - 0.5f + kMargin_px;
  const float bottom = static_cast<float>(block.y + block.size) - 0.5f + kMargin_px;
  vertices.push_back({left, top, block.inverse_depth[0], bits});
  vertices.push_back({right, top, block.inverse_depth[1], bits});
  vertices.push_back({left, bottom, block.inverse_depth[2], bits});
  vertices.push_back({right, bottom, block.inverse_depth[3], bits});
}

/// Two triangles for each four vertices.
std::vector<GLuint> indices_for(std::size_t blocks) {
  std::vector<GLuint> indices;
  indices.reserve(6 * blocks);
  for (std::size_t i = 0; i < blocks; ++i) {
    const auto first = static_cast<GLuint>(4 * i);
    indices.insert(indices.end(), {first, first + 1, first + 2, first + 2, first + 1, first + 3});
  }
  return indices;
}

// Expected depth where it stands in for a missing measurement.
DepthImage stand_ins(const Comparison& comparison) {
  DepthImage depth{comparison.expected.width(), comparison.expected.height()};
  std::transform(comparison.labels.pixels().begin(), comparison.labels.pixels().end(),
                 comparison.expected.pixels().begin(), depth.pixels().begin(),
                 [](Label label, float z) { return label == Label::unmeasured ? z : 0.0f; });
  return depth;
}

class GlCarrier final : public Carrier {
 public:
  GlCarrier(GpuContext& context, Program program, Targets targets)
      : context_{context}, program_{std::move(program)}, targets_{std::move(targets)} {
    glBindVertexArray(vertex_array_.name());
    glBindBuffer(GL_ARRAY_BUFFER, vertices_.name());
    glVertexAttribPointer(kPlace, 3, GL_FLOAT, GL_FALSE, sizeof(Vertex), nullptr);
    glVertexAttribIPointer(kBlock, 1, GL_UNSIGNED_INT, sizeof(Vertex),
                           reinterpret_cast<const void*>(3 * sizeof(float)));
    glEnableVertexAttribArray(kPlace);
    glEnableVertexAttribArray(kBlock);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.name());
    glBindVertexArray(0);
  }
  GlCarrier(const GlCarrier&) = delete;
  GlCarrier& operator=(const GlCarrier&) = delete;
  // The members are freed in the context that made them.
  ~GlCarrier() override { context_.make_current(); }

  Result<Image<std::uint32_t>> carry(const Comparison& comparison, const DepthImage& measured, const Rig& rig) override;

 private:
  void prepare(const Rig& rig);
  void upload(const std::vector<Block>& front, const std::vector<Block>& behind);
  static void draw(std::size_t first_block, std::size_t blocks, float nearest, float farthest);

  GpuContext& context_;
  Program program_;
  Targets targets_;
  VertexArray vertex_array_;
  Buffer vertices_;
  Buffer indices_;
  std::size_t indexed_blocks_ = 0;
};

// Everything that the drawing depends on is set here: the context is shared with other drawing.
void GlCarrier::prepare(const Rig& rig) {
  if (rig.color.width != targets_.width || rig.color.height != targets_.height) {
    targets_ = Targets(rig.color.width, rig.color.height);
  }
  glBindFramebuffer(GL_FRAMEBUFFER, targets_.framebuffer.name());
  glViewport(0, 0, targets_.width, targets_.height);
  for (const GLenum off :
       std::initializer_list<GLenum>{GL_CULL_FACE, GL_BLEND, GL_STENCIL_TEST, GL_DITHER, GL_POLYGON_OFFSET_FILL,
                                     GL_RASTERIZER_DISCARD, GL_SAMPLE_ALPHA_TO_COVERAGE, GL_SCISSOR_TEST}) {
    glDisable(off);
  }
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  glDepthMask(GL_TRUE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  constexpr std::array<GLuint, 4> kUnknown{0, 0, 0, 0};
  constexpr float kFarthest = 1;
  glClearBufferuiv(GL_COLOR, 0, kUnknown.data());
  glClearBufferfv(GL_DEPTH, 0, &kFarthest);
  program_.use();
  const Eigen::Matrix4f matrix = clip_from_place(rig);
  glUniformMatrix4fv(kClipFromPlace, 1, GL_FALSE, matrix.data());
  glUniform1i(kDepthWidth, rig.depth.width);
}

void GlCarrier::upload(const std::vector<Block>& front, const std::vector<Block>& behind) {
  std::vector<Vertex> vertices;
  vertices.reserve(4 * (front.size() + behind.size()));
  for (const Block& block : front) append(vertices, block);
  for (const Block& block : behind) append(vertices, block);
  const auto bytes = [](const auto& of) { return static_cast<GLsizeiptr>(of.size() * sizeof(of[0])); };
  glBindVertexArray(vertex_array_.name());
  glBindBuffer(GL_ARRAY_BUFFER, vertices_.name());
  glBufferData(GL_ARRAY_BUFFER, bytes(vertices), vertices.data(), GL_STREAM_DRAW);
  const std::size_t blocks = front.size() + behind.size();
  if (blocks <= indexed_blocks_) return;
  indexed_blocks_ = 2 * blocks;
  const auto indices = indices_for(indexed_blocks_);
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, bytes(indices), indices.data(), GL_STATIC_DRAW);
}

void GlCarrier::draw(std::size_t first_block, std::size_t blocks, float nearest, float farthest) {
  glDepthRangef(nearest, farthest);
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(6 * blocks), GL_UNSIGNED_INT,
                 reinterpret_cast<const void*>(6 * first_block * sizeof(GLuint)));
}

Result<Image<std::uint32_t>> GlCarrier::carry(const Comparison& comparison, const DepthImage& measured,
                                              const Rig& rig) {
  const BlockRules rules = rules_of(rig);
  const auto front = make_blocks(measured, rules);
  const auto behind = make_blocks(stand_ins(comparison), rules);
  context_.make_current();
  prepare(rig);
  upload(front, behind);
  // Whatever was measured lies before all that was only expected.
  draw(0, front.size(), 0.0f, 0.5f);
  draw(front.size(), behind.size(), 0.5f, 1.0f);
  glDepthRangef(0, 1);
  glBindVertexArray(0);
  Image<std::uint32_t> source{targets_.width, targets_.height};
  read_unsigned(targets_.framebuffer, GL_COLOR_ATTACHMENT0, targets_.width, targets_.height, source.data());
  if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
    return fail(fmt::format("the graphics driver could not draw a view of {} x {} pixels (OpenGL error {:#x})",
                            source.width(), source.height(), error));
  }
  return source;
}

}  // namespace

Result<std::unique_ptr<Carrier>> Carrier::create(GpuContext& context) {
  constexpr int kFirstSize = 16;
  context.make_current();
  auto program = Program::create(shaders::carry_vert, shaders::carry_frag);
  if (!program) return fail("preparing the view over colour", program.error());
  Targets targets(kFirstSize, kFirstSize);
  if (auto usable = check_framebuffer("images of whole numbers"); !usable) return fail(usable.error());
  return std::unique_ptr<Carrier>{std::make_unique<GlCarrier>(context, std::move(*program), std::move(targets))};
}

}  // namespace meshloop::show
