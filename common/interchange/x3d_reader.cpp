#include "common/interchange/x3d_reader.h"

#include <expat.h>
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>

#include "common/interchange/mapped_file.h"
#include "common/interchange/scene_geometry.h"

namespace meshloop {
namespace {

/// The field of a parent in which a node stands when the file does not say (containerField).
std::string_view default_field(std::string_view type) {
  for (const std::string_view kind : {"Coordinate", "CoordinateDouble"}) {
    if (type == kind) return "coord";
  }
  if (type == "Color" || type == "ColorRGBA") return "color";
  if (type == "Appearance") return "appearance";
  if (type == "Material") return "material";
  return is_geometry(type) ? "geometry" : "children";
}

/// Numbers up to the first word that is none: fields that hold text have no numbers, or ones that nobody asks for.
std::vector<double> numbers_in(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n,";
  std::vector<double> numbers;
  if (text == "true" || text == "TRUE") return {1};
  if (text == "false" || text == "FALSE") return {0};
  for (;;) {
    const auto start = text.find_first_not_of(kBlank);
    if (start == std::string_view::npos) return numbers;
    text.remove_prefix(start + (text[start] == '+' ? 1 : 0));
    double value = 0;
    const auto parsed = std::from_chars(text.data(), text.data() + text.size(), value);
    if (parsed.ec != std::errc{}) return numbers;
    numbers.push_back(value);
    text.remove_prefix(static_cast<std::size_t>(parsed.ptr - text.data()));
  }
}

class Builder {
 public:
  void start(std::string_view type, const char** attributes) {
    if (!error_.empty()) return;
    if (type == "unit") add_unit(attributes);
    if (type == "Scene") {
      if (in_scene_) return refuse("a Scene stands within a Scene");
      in_scene_ = true;
      return;
    }
    if (!in_scene_) return;
    if (type == "ProtoDeclare" || type == "ExternProtoDeclare" || type == "ProtoInstance") {
      return refuse(fmt::format("{} is not read; export the scene without it", type));
    }
    if (open_.size() >= kMaxNesting) return refuse("nodes are nested too deeply");
    open_.push_back(opened(type, attributes));
  }

  void end(std::string_view type) {
    if (!error_.empty() || !in_scene_) return;
    if (type == "Scene") {
      in_scene_ = false;
      return;
    }
    Open done = std::move(open_.back());
    open_.pop_back();
    if (!done.used) {
      done.node->height = height_of(*done.node);
      if (done.node->height > kMaxNesting) return refuse("nodes are nested too deeply");
      // Only now: a node cannot use itself.
      if (!done.node->name.empty()) named_[done.node->name] = done.node;
    }
    WebNodes& parent = open_.empty() ? scene_.nodes : open_.back().node->fields[done.field].nodes;
    if (!open_.empty() && open_.back().used) return;
    parent.push_back(done.used ? done.used : std::shared_ptr<const WebNode>{done.node});
  }

  void refuse(std::string why) {
    if (error_.empty()) error_ = std::move(why);
  }

  [[nodiscard]] Result<X3dScene> take() {
    if (!error_.empty()) return fail(error_);
    return std::move(scene_);
  }

 private:
  struct Open {
    std::shared_ptr<WebNode> node = std::make_shared<WebNode>();
    std::shared_ptr<const WebNode> used;
    std::string field;
  };

  Open opened(std::string_view type, const char** attributes) {
    Open open;
    open.node->type = type;
    open.field = default_field(type);
    // A geometry that this program does not know must not be passed over.
    const bool in_shape = !open_.empty() && open_.back().node->type == "Shape";
    if (in_shape && open.field == "children") open.field = type.starts_with("Metadata") ? "metadata" : "geometry";
    for (; *attributes != nullptr; attributes += 2) {
      const std::string_view name{attributes[0]}, value{attributes[1]};
      if (name == "DEF") {
        open.node->name = value;
      } else if (name == "USE") {
        const auto found = named_.find(value);
        if (found == named_.end()) {
          refuse(fmt::format("USE names '{}', which no DEF before it does", value));
        } else {
          open.used = found->second;
        }
      } else if (name == "containerField") {
        open.field = value;
      } else {
        open.node->fields[std::string{name}].numbers = numbers_in(value);
      }
    }
    return open;
  }

  void add_unit(const char** attributes) {
    bool length = false;
    double factor = 0;
    for (; *attributes != nullptr; attributes += 2) {
      const std::string_view name{attributes[0]}, value{attributes[1]};
      length |= name == "category" && value == "length";
      if (const auto numbers = numbers_in(value); name == "conversionFactor" && !numbers.empty()) factor = numbers[0];
    }
    if (!length) return;
    if (!(factor > 0) || !std::isfinite(factor)) return refuse("its unit of length is no positive number of metres");
    scene_.unit_m = factor;
  }

  X3dScene scene_;
  bool in_scene_ = false;
  std::vector<Open> open_;
  std::map<std::string, std::shared_ptr<const WebNode>, std::less<>> named_;
  std::string error_;
};

void XMLCALL on_start(void* builder, const char* type, const char** attributes) {
  static_cast<Builder*>(builder)->start(type, attributes);
}

void XMLCALL on_end(void* builder, const char* type) {
  static_cast<Builder*>(builder)->end(type);
}

}  // namespace

Result<X3dScene> parse_x3d(std::string_view text) {
  if (text.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) return fail("it is larger than 2 GB");
  // Expat follows no external entities unless it is told to, and bounds what internal ones expand to.
  const std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser{XML_ParserCreate(nullptr), XML_ParserFree};
  if (!parser) return fail("there is no memory for it");
  Builder builder;
  XML_SetUserData(parser.get(), &builder);
  XML_SetElementHandler(parser.get(), on_start, on_end);
  if (XML_Parse(parser.get(), text.data(), static_cast<int>(text.size()), XML_TRUE) != XML_STATUS_OK) {
    return fail(fmt::format("line {}: {}", XML_GetCurrentLineNumber(parser.get()),
                            XML_ErrorString(XML_GetErrorCode(parser.get()))));
  }
  return builder.take();
}

Result<ReadParts> read_x3d(const std::filesystem::path& file, const Progress& progress) {
  const auto content = MappedFile::open(file);
  if (!content) return fail(content.error());
  const auto scene = parse_x3d(content->text());
  if (!scene) return fail(scene.error());
  progress(0.5);
  auto parts = parts_of(scene->nodes, file.stem().string());
  if (!parts) return fail(parts.error());
  // Metres by the standard's definition (19775-1, 4.3.6), unless the file has a unit statement.
  return ReadParts{std::move(*parts), {scene->unit_m, LengthUnit::Source::stated}};
}

}  // namespace meshloop
