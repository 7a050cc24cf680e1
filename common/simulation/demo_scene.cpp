#include "common/simulation/demo_scene.h"

#include <array>
#include <cmath>
#include <numbers>

#include "common/features/markers.h"
#include "common/simulation/random.h"
#include "common/simulation/room.h"
#include "common/simulation/scene.h"
#include "common/simulation/texture.h"

namespace meshloop::simulation {
namespace {

constexpr double kMarkerSide_m = 0.12;
constexpr double kMarkerMargin_m = 0.014;
constexpr const char* kDictionary = "DICT_4X4_50";

struct MarkerPlace {
  int id;
  double x, y, turn_deg;
};
constexpr std::array<MarkerPlace, 6> kMarkerPlaces{{{0, -0.50, -0.216, 4},
                                                    {1, 0.04, -0.214, -3},
                                                    {2, 0.52, -0.214, 6},
                                                    {3, 0.52, 0.216, 183},
                                                    {4, 0.05, 0.216, 177},
                                                    {5, -0.50, 0.214, 185}}};

Pose placed(double x, double y, double z, double turn_deg = 0) {
  return make_pose({x, y, z},
                   Eigen::Quaterniond(Eigen::AngleAxisd(turn_deg * std::numbers::pi / 180, Eigen::Vector3d::UnitZ())));
}

/// The markers as print on the sideboard's top.
class MarkerPrint {
 public:
  MarkerPrint() {
    const auto detector = MarkerDetector::create(kDictionary);
    if (!detector) return;
    for (const MarkerPlace& place : kMarkerPlaces) {
      auto pattern = detector->pattern(place.id);
      if (!pattern) continue;
      prints_.push_back({place.x, place.y, placed(place.x, place.y, 0, place.turn_deg).inverse(), std::move(*pattern)});
    }
  }

  /// Ink or paper at a point of the top; nothing outside the markers.
  [[nodiscard]] std::optional<Rgb8> at(double x, double y) const {
    constexpr double kReach_m = kMarkerSide_m / 2 + kMarkerMargin_m;
    // Most of the top is bare: no marker, however turned, reaches farther than its diagonal.
    constexpr double kFarthest_m = kReach_m * std::numbers::sqrt2;
    for (const Print& print : prints_) {
      if (std::abs(x - print.x) > kFarthest_m || std::abs(y - print.y) > kFarthest_m) continue;
      const Eigen::Vector3d p = print.T_marker_world * Eigen::Vector3d(x, y, 0);
      if (std::abs(p.x()) > kReach_m || std::abs(p.y()) > kReach_m) continue;
      const double column = std::floor((p.x() / kMarkerSide_m + 0.5) * print.pattern.width());
      const double row = std::floor((0.5 - p.y() / kMarkerSide_m) * print.pattern.height());
      if (column < 0 || row < 0 || column >= print.pattern.width() || row >= print.pattern.height()) return kPaper;
      return print.pattern(static_cast<int>(column), static_cast<int>(row)) > 127 ? kPaper : kInk;
    }
    return std::nullopt;
  }

 private:
  static constexpr Rgb8 kPaper{224, 224, 220};
  static constexpr Rgb8 kInk{26, 26, 28};
  struct Print {
    double x, y;
    Pose T_marker_world;
    GreyImage pattern;
  };
  std::vector<Print> prints_;
};

/// Puts solids together, one object after the other.
class SceneBuilder {
 public:
  explicit SceneBuilder(std::uint64_t seed) : seed_{seed} {}

  [[nodiscard]] Scene take() { return std::move(scene_); }

  void begin_object(std::string object, const Pose& T_world_object, bool modelled) {
    object_ = std::move(object);
    T_world_object_ = T_world_object;
    modelled_ = modelled;
  }

  Solid& add(const char* name, const Eigen::Vector3d& size, const Pose& T_object_solid, Texture texture,
             Solid::Shape shape = Solid::Shape::box) {
    Solid solid;
    solid.name = name;
    solid.shape = shape;
    solid.size = size;
    solid.T_world_solid = T_world_object_ * T_object_solid;
    solid.texture = std::move(texture);
    solid.modelled = modelled_;
    solid.object = object_;
    return scene_.solids.emplace_back(std::move(solid));
  }

  Solid& add_plain(const char* name, const Eigen::Vector3d& size, const Pose& T_object_solid, Rgb8 color,
                   Solid::Shape shape = Solid::Shape::box) {
    return add(name, size, T_object_solid, plain(color, size, next_seed()), shape);
  }

  [[nodiscard]] std::uint64_t next_seed() { return mix(seed_++); }

 private:
  std::uint64_t seed_;
  Scene scene_;
  std::string object_;
  Pose T_world_object_ = Pose::Identity();
  bool modelled_ = false;
};

void add_sideboard(SceneBuilder& builder) {
  builder.begin_object("sideboard", Pose::Identity(), true);
  const Texture light = wood({222, 194, 154}, {186, 150, 108}, builder.next_seed());
  const Texture dark = wood({124, 88, 60}, {86, 58, 38}, builder.next_seed());
  const Texture door = wood({146, 106, 74}, {106, 74, 50}, builder.next_seed());
  Solid& top = builder.add("top", {1.6, 0.6, 0.03}, placed(0, 0, -0.015), light);
  top.mesh_texture = light;
  top.texture = [light, print = MarkerPrint{}](const Eigen::Vector3d& p, const Eigen::Vector3d& normal) {
    const auto ink = normal.z() > 0.5 ? print.at(p.x(), p.y()) : std::nullopt;
    return ink ? *ink : light(p, normal);
  };
  builder.add("body", {1.52, 0.54, 0.39}, placed(0, 0, -0.225), dark);
  for (const double side : {-1.0, 1.0}) {
    for (const double x : {-0.505, 0.0, 0.505}) {
      builder.add("door", {0.48, 0.014, 0.35}, placed(x, side * 0.277, -0.225), door);
      builder.add_plain("handle", {0.10, 0.016, 0.016}, placed(x, side * 0.292, -0.12), {196, 190, 178});
    }
    for (const double x : {-0.68, 0.68}) {
      builder.add("leg", {0.05, 0.05, 0.08}, placed(x, side * 0.20, -0.46), dark, Solid::Shape::cylinder);
    }
  }
}

struct Brick {
  /// Centre in units of the studs' pitch, layer from the sideboard upwards.
  double x, y;
  int layer;
  bool turned;
  Rgb8 color;
};

constexpr double kPitch_m = 0.055;
constexpr double kBrickHeight_m = 0.08;
constexpr Rgb8 kBrickRed{204, 38, 36};
constexpr Rgb8 kBrickYellow{244, 200, 40};
constexpr Rgb8 kBrickBlue{28, 92, 176};
constexpr Rgb8 kBrickGreen{44, 142, 70};
constexpr Rgb8 kBrickWhite{228, 226, 218};
constexpr Rgb8 kBrickOrange{236, 120, 30};

/// A house of six bricks and one that lies beside it (with its own pose).
constexpr std::array<Brick, 6> kHouse{{{0, -1, 0, false, kBrickRed},
                                       {0, 1, 0, false, kBrickBlue},
                                       {-1, 0, 1, true, kBrickYellow},
                                       {1, 0, 1, true, kBrickGreen},
                                       {0, 1, 2, false, kBrickWhite},
                                       {-1, 0, 3, true, kBrickRed}}};

bool is_covered(double x, double y, int layer) {
  for (const Brick& brick : kHouse) {
    const double half_x = brick.turned ? 1 : 2;
    const double half_y = brick.turned ? 2 : 1;
    if (brick.layer == layer && std::abs(x - brick.x) < half_x && std::abs(y - brick.y) < half_y) return true;
  }
  return false;
}

void add_brick(SceneBuilder& builder, const Brick& brick, bool free) {
  const double bottom = brick.layer * kBrickHeight_m;
  const Pose T_object_brick =
      placed(brick.x * kPitch_m, brick.y * kPitch_m, bottom + kBrickHeight_m / 2, brick.turned ? 90 : 0);
  const Eigen::Vector3d size(4 * kPitch_m, 2 * kPitch_m, kBrickHeight_m);
  builder.add_plain("brick", size, T_object_brick, brick.color).mesh_detail = 1.4;
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 2; ++row) {
      const Pose T_brick_stud = placed((column - 1.5) * kPitch_m, (row - 0.5) * kPitch_m, kBrickHeight_m / 2 + 0.009);
      const Pose T_object_stud = T_object_brick * T_brick_stud;
      const Eigen::Vector3d p = T_object_stud.translation() / kPitch_m;
      // A stud inside the brick above is not to be seen.
      if (!free && is_covered(p.x(), p.y(), brick.layer + 1)) continue;
      builder.add_plain("stud", {0.034, 0.034, 0.018}, T_object_stud, brick.color, Solid::Shape::cylinder);
    }
  }
}

void add_bricks(SceneBuilder& builder) {
  builder.begin_object("bricks", placed(-0.07, 0, 0), true);
  for (const Brick& brick : kHouse) add_brick(builder, brick, false);
  builder.begin_object("bricks", placed(-0.28, 0.0, 0, 98), true);
  add_brick(builder, {0, 0, 0, false, kBrickOrange}, true);
}

void add_box(SceneBuilder& builder) {
  const Eigen::Vector3d size(0.26, 0.18, 0.20);
  builder.begin_object("box", placed(0.31, 0.0, 0, -14), false);
  builder.add("box", size, placed(0, 0, size.z() / 2), wrapping_paper(size, builder.next_seed())).mesh_detail = 4;
}

void add_car(SceneBuilder& builder) {
  constexpr Rgb8 kPaint{24, 150, 190};
  constexpr Rgb8 kGlass{44, 60, 76};
  constexpr Rgb8 kTyre{34, 34, 36};
  constexpr Rgb8 kLamp{252, 240, 190};
  builder.begin_object("car", placed(-0.53, 0.0, 0, 24), false);
  builder.add_plain("chassis", {0.24, 0.096, 0.042}, placed(0, 0, 0.047), kPaint);
  builder.add_plain("windows", {0.118, 0.084, 0.034}, placed(-0.012, 0, 0.085), kGlass);
  builder.add_plain("roof", {0.10, 0.088, 0.010}, placed(-0.012, 0, 0.107), {240, 240, 236});
  builder.add_plain("bumper", {0.008, 0.090, 0.014}, placed(0.124, 0, 0.038), {206, 206, 210});
  builder.add_plain("bumper", {0.008, 0.090, 0.014}, placed(-0.124, 0, 0.038), {206, 206, 210});
  for (const double side : {-1.0, 1.0}) {
    builder.add_plain("lamp", {0.004, 0.018, 0.014}, placed(0.122, side * 0.032, 0.056), kLamp);
    builder.add_plain("lamp", {0.004, 0.018, 0.012}, placed(-0.122, side * 0.032, 0.056), {214, 40, 36});
    for (const double x : {-0.072, 0.072}) {
      const Pose T_object_axle =
          placed(x, side * 0.047, 0.027) * Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX());
      builder.add_plain("tyre", {0.054, 0.054, 0.020}, T_object_axle, kTyre, Solid::Shape::cylinder);
      builder.add_plain("hub", {0.028, 0.028, 0.023}, T_object_axle, {214, 214, 218}, Solid::Shape::cylinder);
    }
  }
}

}  // namespace

MarkerMap demo_markers() {
  constexpr double kHalf = kMarkerSide_m / 2;
  MarkerMap map;
  map.dictionary = kDictionary;
  for (const MarkerPlace& place : kMarkerPlaces) {
    const Pose T_world_marker = placed(place.x, place.y, 0, place.turn_deg);
    Marker marker;
    marker.id = place.id;
    marker.corners = {
        T_world_marker * Eigen::Vector3d(-kHalf, kHalf, 0), T_world_marker * Eigen::Vector3d(kHalf, kHalf, 0),
        T_world_marker * Eigen::Vector3d(kHalf, -kHalf, 0), T_world_marker * Eigen::Vector3d(-kHalf, -kHalf, 0)};
    map.markers.push_back(marker);
  }
  return map;
}

Scene make_demo_scene(unsigned seed) {
  SceneBuilder builder(mix(seed));
  add_sideboard(builder);
  add_bricks(builder);
  add_box(builder);
  add_car(builder);
  Scene scene = builder.take();
  scene.background = living_room(builder.next_seed());
  return scene;
}

Scene with_moved_object(Scene scene, const std::string& object, const Eigen::Vector3d& offset_m) {
  for (Solid& solid : scene.solids) {
    if (solid.object == object) solid.T_world_solid.pretranslate(offset_m);
  }
  return scene;
}

}  // namespace meshloop::simulation
