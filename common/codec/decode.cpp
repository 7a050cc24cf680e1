#include "common/codec/mesh_codec.h"

#include <fmt/format.h>

#include <exception>
#include <utility>

#include "common/codec/draco_header.h"
#include "common/codec/draco_part.h"
#include "common/codec/mesh_tail.h"
#include "common/codec/texture_frame.h"
#include "common/image/jpeg_codec.h"
#include "common/mesh/lattice.h"

namespace meshloop {
namespace {

Status check_claims(std::span<const std::byte> bytes, const DecodeLimits& limits) {
  const auto counts = read_draco_counts(bytes);
  if (!counts) return fail(counts.error());
  if (counts->most_vertices() > limits.max_vertices || counts->faces > limits.max_triangles) {
    return fail(
        fmt::format("the payload claims {} vertices with splits and {} triangles; at most {} and {} are accepted",
                    counts->most_vertices(), counts->faces, limits.max_vertices, limits.max_triangles));
  }
  if (counts->faces > kMaxTrianglesPerByte * bytes.size()) {
    return fail("the payload claims more triangles than its bytes can hold");
  }
  return {};
}

Result<Submesh> decode_checked(std::span<const std::byte> bytes, const DecodeLimits& limits) {
  auto part = read_draco_part(bytes);
  if (!part) return fail(part.error());
  auto& mesh = part->mesh;
  // The claims bound it; this does not rely on Draco keeping to them.
  if (mesh.positions.size() > limits.max_vertices) return fail("the payload has more vertices than it claims");
  if (auto ok = read_mesh_tail(bytes.subspan(part->bytes), mesh); !ok) return fail("the payload's end", ok.error());
  if (auto ok = validate(mesh); !ok) return fail("the payload", ok.error());
  if (!is_on_lattice(mesh)) return fail("the payload has positions off the scene's lattice");
  return std::move(mesh);
}

Result<Submesh> decode_mesh(std::span<const std::byte> bytes, const DecodeLimits& limits) {
  if (auto ok = check_claims(bytes, limits); !ok) return fail(ok.error());
  try {
    return decode_checked(bytes, limits);
  } catch (const std::exception& error) {
    return fail(fmt::format("the Draco payload is damaged ({})", error.what()));
  }
}

/// The picture is decoded to see that it can be; who draws it does so again.
Result<Submesh> decode_with_texture(std::span<const std::byte> bytes, const DecodeLimits& limits) {
  const auto frame = split_texture_frame(bytes);
  if (!frame) return fail(frame.error());
  auto texture = make_projected_texture({frame->jpeg.begin(), frame->jpeg.end()}, frame->projection);
  if (!texture) return fail("the payload", texture.error());
  if (const auto picture = decode_jpeg(frame->jpeg); !picture) return fail("the payload's texture", picture.error());
  auto submesh = decode_mesh(frame->mesh, limits);
  if (!submesh) return submesh;
  submesh->texture = std::move(*texture);
  if (auto ok = validate(*submesh); !ok) return fail("the payload", ok.error());
  return submesh;
}

}  // namespace

Result<Submesh> decode(std::span<const std::byte> bytes, const DecodeLimits& limits) {
  if (bytes.size() > limits.max_bytes) {
    return fail(fmt::format("the payload has {} bytes; at most {} are accepted", bytes.size(), limits.max_bytes));
  }
  return is_texture_frame(bytes) ? decode_with_texture(bytes, limits) : decode_mesh(bytes, limits);
}

}  // namespace meshloop
