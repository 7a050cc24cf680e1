#include "common/interchange/part_buffer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <type_traits>
#include <utility>

namespace meshloop {
namespace {

using Texture = std::shared_ptr<const ProjectedTexture>;

class Writer {
 public:
  explicit Writer(const WriteBytes& write) : write_{write} {}

  void number(std::uint64_t value) { append(std::as_bytes(std::span{&value, 1})); }

  template <class List>
  void list(const List& values) {
    number(values.size());
    append(std::as_bytes(std::span{values}));
  }

  /// None is two empty lists: one way only to write each texture, so that what is read is what was written.
  void texture(const Texture& texture) {
    if (!texture) {
      number(0);
      number(0);
      return;
    }
    list(std::vector<float>(texture->projection.data(), texture->projection.data() + texture->projection.size()));
    list(texture->jpeg);
  }

  [[nodiscard]] bool good() const { return good_; }

 private:
  void append(std::span<const std::byte> more) { good_ = good_ && write_(more); }

  const WriteBytes& write_;
  bool good_ = true;
};

class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : rest_{bytes} {}

  bool number(std::uint64_t& value) {
    if (rest_.size() < sizeof value) return false;
    std::memcpy(&value, rest_.data(), sizeof value);
    rest_ = rest_.subspan(sizeof value);
    return true;
  }

  template <class List>
  bool list(List& values) {
    using Element = typename List::value_type;
    std::uint64_t count = 0;
    if (!number(count) || count > rest_.size() / sizeof(Element)) return false;
    values.resize(count);
    if (count > 0) std::memcpy(static_cast<void*>(values.data()), rest_.data(), count * sizeof(Element));
    rest_ = rest_.subspan(count * sizeof(Element));
    return true;
  }

  bool texture(Texture& texture) {
    std::vector<float> values;
    std::vector<std::byte> jpeg;
    TextureProjection projection;
    if (!list(values) || !list(jpeg)) return false;
    if (values.empty() && jpeg.empty()) return true;
    if (values.size() != static_cast<std::size_t>(projection.size())) return false;
    std::copy(values.begin(), values.end(), projection.data());
    auto made = make_projected_texture(std::move(jpeg), projection);
    if (made) texture = std::move(*made);
    return made.has_value();
  }

  [[nodiscard]] bool at_end() const { return rest_.empty(); }

 private:
  std::span<const std::byte> rest_;
};

}  // namespace

bool write_parts(const ReadParts& read, const WriteBytes& write) {
  Writer out{write};
  out.number(std::bit_cast<std::uint64_t>(read.unit.metres));
  out.number(static_cast<std::uint64_t>(read.unit.source));
  out.number(read.parts.size());
  for (const auto& part : read.parts) {
    out.list(part.name);
    out.list(part.submesh.positions);
    out.list(part.submesh.colors);
    out.list(part.submesh.triangles);
    out.texture(part.submesh.texture);
  }
  return out.good();
}

Result<ReadParts> parts_from_bytes(std::span<const std::byte> bytes) {
  Reader in{bytes};
  ReadParts read;
  std::uint64_t metres = 0;
  std::uint64_t source = 0;
  std::uint64_t count = 0;
  bool complete = in.number(metres) && in.number(source) && in.number(count);
  read.unit = {std::bit_cast<double>(metres), static_cast<LengthUnit::Source>(source)};
  complete = complete && std::isfinite(read.unit.metres) && read.unit.metres > 0 &&
             source <= static_cast<std::uint64_t>(LengthUnit::Source::given);
  for (std::uint64_t i = 0; complete && i < count; ++i) {
    ImportedPart part;
    complete = in.list(part.name) && in.list(part.submesh.positions) && in.list(part.submesh.colors) &&
               in.list(part.submesh.triangles) && in.texture(part.submesh.texture);
    if (complete) read.parts.push_back(std::move(part));
  }
  if (!complete || !in.at_end()) return fail("the importer's result is damaged");
  return read;
}

}  // namespace meshloop
