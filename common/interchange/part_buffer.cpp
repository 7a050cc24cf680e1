#include "common/interchange/part_buffer.h"

#include <cstdint>
#include <cstring>
#include <type_traits>

namespace meshloop {
namespace {

class Writer {
 public:
  void number(std::uint64_t value) { append(std::as_bytes(std::span{&value, 1})); }

  template <class List>
  void list(const List& values) {
    number(values.size());
    append(std::as_bytes(std::span{values}));
  }

  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  void append(std::span<const std::byte> more) { bytes_.insert(bytes_.end(), more.begin(), more.end()); }

  std::vector<std::byte> bytes_;
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

  [[nodiscard]] bool at_end() const { return rest_.empty(); }

 private:
  std::span<const std::byte> rest_;
};

}  // namespace

std::vector<std::byte> to_bytes(const std::vector<ImportedPart>& parts) {
  Writer out;
  out.number(parts.size());
  for (const auto& part : parts) {
    out.list(part.name);
    out.list(part.submesh.positions);
    out.list(part.submesh.colors);
    out.list(part.submesh.triangles);
  }
  return out.take();
}

Result<std::vector<ImportedPart>> parts_from_bytes(std::span<const std::byte> bytes) {
  Reader in{bytes};
  std::uint64_t count = 0;
  bool complete = in.number(count);
  std::vector<ImportedPart> parts;
  for (std::uint64_t i = 0; complete && i < count; ++i) {
    ImportedPart part;
    complete = in.list(part.name) && in.list(part.submesh.positions) && in.list(part.submesh.colors) &&
               in.list(part.submesh.triangles);
    if (complete) parts.push_back(std::move(part));
  }
  if (!complete || !in.at_end()) return fail("the importer's result is damaged");
  return parts;
}

}  // namespace meshloop
