#include "common/implicit/shape_file.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string_view>

namespace meshloop {
namespace {

constexpr std::size_t kMostShapes = 1000;
constexpr std::uintmax_t kLargestFile = 1 << 20;
constexpr int kMaxNesting = 32;

/// Leaves the parser as a message; parse_shapes makes it an error.
[[noreturn]] void refuse(const YAML::Node& at, const std::string& why) {
  throw std::runtime_error(fmt::format("line {}: {}", at.Mark().line + 1, why));
}

double number(const YAML::Node& node) {
  double value = 0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value)) {
    refuse(node, "a number is expected");
  }
  return value;
}

Eigen::Vector3d vector(const YAML::Node& node) {
  if (!node.IsSequence() || node.size() != 3) refuse(node, "three numbers in brackets are expected");
  return {number(node[0]), number(node[1]), number(node[2])};
}

void check_keys(const YAML::Node& node, std::initializer_list<std::string_view> allowed) {
  if (!node.IsMap()) refuse(node, "keys with values are expected");
  for (const auto& item : node) {
    const auto key = item.first.as<std::string>();
    if (std::find(allowed.begin(), allowed.end(), key) == allowed.end()) {
      refuse(item.first, fmt::format("'{}' is unknown here", key));
    }
  }
}

const YAML::Node required(const YAML::Node& node, const char* key) {
  const YAML::Node value = node[key];
  if (!value) refuse(node, fmt::format("'{}' is missing", key));
  return value;
}

struct PrimitiveFormat {
  std::string_view name;
  Primitive::Kind kind;
  /// Where size.x and size.y come from; the box has one key for all three.
  std::array<const char*, 2> keys;
};

constexpr std::array<PrimitiveFormat, 6> kPrimitives{{
    {"sphere", Primitive::Kind::sphere, {"radius", nullptr}},
    {"box", Primitive::Kind::box, {"size", nullptr}},
    {"plane", Primitive::Kind::plane, {nullptr, nullptr}},
    {"cylinder", Primitive::Kind::cylinder, {"radius", "height"}},
    {"cone", Primitive::Kind::cone, {"radius", "height"}},
    {"torus", Primitive::Kind::torus, {"radius", "tube"}},
}};

class ShapeReader {
 public:
  /// The one key of the map that names a primitive or an operation.
  void add(const YAML::Node& node, const Pose& T_node_parent, int depth) {
    if (depth > kMaxNesting) refuse(node, "operations are nested too deeply");
    if (!node.IsMap() || node.size() != 1) refuse(node, "one primitive or operation is expected");
    const auto item = *node.begin();
    const auto name = item.first.as<std::string>();
    for (const auto& format : kPrimitives) {
      if (format.name == name) return add_primitive(format, item.second, T_node_parent);
    }
    if (name == "transform") return add_transform(item.second, T_node_parent, depth);
    if (name == "union") return add_operation(ShapeStep::kUnion, item.second, T_node_parent, depth);
    if (name == "intersection") return add_operation(ShapeStep::kIntersection, item.second, T_node_parent, depth);
    if (name == "difference") return add_operation(ShapeStep::kDifference, item.second, T_node_parent, depth);
    refuse(item.first, fmt::format("'{}' is no primitive and no operation", name));
  }

  Shape take() { return std::move(shape_); }

 private:
  void add_primitive(const PrimitiveFormat& format, const YAML::Node& node, const Pose& T_node_parent) {
    Primitive primitive;
    primitive.kind = format.kind;
    primitive.T_primitive_node = T_node_parent.inverse();
    if (format.kind == Primitive::Kind::box) {
      check_keys(node, {"size"});
      primitive.size = vector(required(node, "size"));
    } else if (format.keys[0] != nullptr) {
      check_keys(node, {format.keys[0], format.keys[1] == nullptr ? "" : format.keys[1]});
      primitive.size.x() = number(required(node, format.keys[0]));
      if (format.keys[1] != nullptr) primitive.size.y() = number(required(node, format.keys[1]));
    } else if (!node.IsNull() && !(node.IsMap() && node.size() == 0)) {
      refuse(node, "a plane has no sizes; move it with a transform");
    }
    if (shape_.primitives.size() == kMaxPrimitives)
      refuse(node, fmt::format("more than {} primitives", kMaxPrimitives));
    shape_.steps.push_back({static_cast<int>(shape_.primitives.size())});
    shape_.primitives.push_back(primitive);
  }

  void add_operation(int operation, const YAML::Node& list, const Pose& T_node_parent, int depth) {
    if (!list.IsSequence() || list.size() < 2) refuse(list, "a list of at least two solids is expected");
    for (std::size_t i = 0; i < list.size(); ++i) {
      add(list[i], T_node_parent, depth + 1);
      if (i > 0) shape_.steps.push_back({operation});
    }
  }

  void add_transform(const YAML::Node& node, const Pose& T_node_parent, int depth) {
    check_keys(node, {"translation", "axis", "angle_deg", "of"});
    Pose T_parent_child = Pose::Identity();
    if (const auto translation = node["translation"]) T_parent_child.translation() = vector(translation);
    if (node["axis"] || node["angle_deg"]) {
      const Eigen::Vector3d axis = vector(required(node, "axis"));
      if (!(axis.norm() > 1e-9)) refuse(node, "the axis has no direction");
      const double angle = number(required(node, "angle_deg")) * std::numbers::pi / 180;
      T_parent_child.linear() = Eigen::AngleAxisd{angle, axis.normalized()}.toRotationMatrix();
    }
    add(required(node, "of"), T_node_parent * T_parent_child, depth + 1);
  }

  Shape shape_;
};

Rgb8 color_of(const YAML::Node& node) {
  const Eigen::Vector3d channels = vector(node);
  const auto byte = [&](Eigen::Index i) {
    if (!(channels[i] >= 0 && channels[i] <= 255)) refuse(node, "a colour is three numbers from 0 to 255");
    return static_cast<std::uint8_t>(std::lround(channels[i]));
  };
  return {byte(0), byte(1), byte(2)};
}

NamedShape named_shape(const YAML::Node& node) {
  check_keys(node, {"name", "color", "solid"});
  NamedShape named;
  named.name = required(node, "name").as<std::string>();
  ShapeReader reader;
  reader.add(required(node, "solid"), Pose::Identity(), 0);
  named.shape = reader.take();
  if (const auto color = node["color"]) named.shape.color = color_of(color);
  if (auto ok = validate(named.shape); !ok) refuse(node, fmt::format("'{}': {}", named.name, ok.error().message));
  return named;
}

}  // namespace

Result<std::vector<NamedShape>> parse_shapes(const std::string& text) {
  try {
    const YAML::Node document = YAML::Load(text);
    check_keys(document, {"shapes"});
    const YAML::Node list = required(document, "shapes");
    if (!list.IsSequence() || list.size() == 0 || list.size() > kMostShapes) {
      refuse(list, fmt::format("'shapes' is a list of 1 to {} shapes", kMostShapes));
    }
    std::vector<NamedShape> shapes;
    for (const auto& node : list) shapes.push_back(named_shape(node));
    return shapes;
  } catch (const std::exception& error) {
    return fail(error.what());
  }
}

Result<std::vector<NamedShape>> read_shapes(const std::filesystem::path& file) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  std::ifstream stream{file, std::ios::binary};
  if (error || !stream) return fail(fmt::format("'{}' could not be read", file.string()));
  if (size > kLargestFile) return fail(fmt::format("'{}' is larger than 1 MB: no file of shapes", file.string()));
  std::ostringstream text;
  text << stream.rdbuf();
  auto shapes = parse_shapes(text.str());
  if (!shapes) return fail(fmt::format("'{}' could not be read", file.string()), shapes.error());
  return shapes;
}

}  // namespace meshloop
