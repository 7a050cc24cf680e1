#include "common/recording/rig_uncertainty.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <vector>

#include "common/recording/yaml_reader.h"

namespace meshloop {
namespace {

Result<SensorModel> parse_measured(const YAML::Node& node) {
  if (auto ok = check_keys(node, "sensor", {"polynomial", "range", "step", "lateral_px"}); !ok) {
    return fail(ok.error());
  }
  SensorNoise noise;
  std::array<double, 2> range{};
  if (auto ok = read_numbers(node["polynomial"], "sensor.polynomial", {noise.axial.data(), 3}); !ok) {
    return fail(ok.error());
  }
  if (auto ok = read_numbers(node["range"], "sensor.range", range); !ok) return fail(ok.error());
  noise.nearest_m = range[0];
  noise.farthest_m = range[1];
  for (const auto& [key, value] : {std::pair{"step", &noise.step_per_m}, std::pair{"lateral_px", &noise.lateral_px}}) {
    const auto number = read_number(node[key], std::string{"sensor."} + key);
    if (!number) return fail(number.error());
    *value = *number;
  }
  return SensorModel::measured(noise);
}

template <int Size>
constexpr std::size_t triangle_size() {
  return static_cast<std::size_t>(Size * (Size + 1) / 2);
}

template <int Size>
Status read_triangle(const YAML::Node& node, const std::string& key, Eigen::Matrix<double, Size, Size>& matrix) {
  if (!node) return {};
  std::array<double, triangle_size<Size>()> numbers{};
  if (auto ok = read_numbers(node, key, numbers); !ok) return ok;
  std::size_t next = 0;
  for (int row = 0; row < Size; ++row) {
    for (int column = row; column < Size; ++column) {
      matrix(row, column) = matrix(column, row) = numbers[next++];
    }
  }
  return {};
}

template <class Matrix>
std::string triangle_text(const Matrix& matrix) {
  std::vector<double> numbers;
  for (int row = 0; row < matrix.rows(); ++row) {
    for (int column = row; column < matrix.cols(); ++column) numbers.push_back(matrix(row, column));
  }
  return fmt::format("[{}]", fmt::join(numbers, ", "));
}

}  // namespace

Result<SensorModel> parse_sensor(const YAML::Node& node) {
  if (node.IsMap() && node["polynomial"]) return parse_measured(node);
  if (node.IsMap()) {
    if (auto ok = check_keys(node, "sensor", {"constant"}); !ok) return fail(ok.error());
    const auto sigma_m = read_number(node["constant"], "sensor.constant");
    if (!sigma_m) return fail(sigma_m.error());
    return SensorModel::constant(*sigma_m);
  }
  const auto name = read_string(node, "sensor");
  if (!name) return fail(name.error());
  return SensorModel::from_name(*name);
}

std::string sensor_text(const SensorModel& sensor) {
  if (sensor.kind() == SensorModel::Kind::constant) return fmt::format("{{constant: {}}}", sensor.constant_m());
  if (sensor.kind() != SensorModel::Kind::measured) return sensor.name();
  const SensorNoise& noise = sensor.noise();
  return fmt::format("{{polynomial: [{}, {}, {}], range: [{}, {}], step: {}, lateral_px: {}}}", noise.axial[0],
                     noise.axial[1], noise.axial[2], noise.nearest_m, noise.farthest_m, noise.step_per_m,
                     noise.lateral_px);
}

Result<CalibrationCovariance> parse_covariance(const YAML::Node& node) {
  CalibrationCovariance covariance;
  if (!node) return covariance;
  if (auto ok = check_keys(node, "covariance", {}, {"depth_intrinsics", "T_depth_color"}); !ok) {
    return fail(ok.error());
  }
  if (auto ok = read_triangle<4>(node["depth_intrinsics"], "covariance.depth_intrinsics", covariance.depth_intrinsics);
      !ok) {
    return fail(ok.error());
  }
  if (auto ok = read_triangle<6>(node["T_depth_color"], "covariance.T_depth_color", covariance.T_depth_color); !ok) {
    return fail(ok.error());
  }
  return covariance;
}

std::string covariance_text(const CalibrationCovariance& covariance) {
  if (covariance.depth_intrinsics.isZero(0) && covariance.T_depth_color.isZero(0)) return "";
  return fmt::format("covariance: {{depth_intrinsics: {}, T_depth_color: {}}}\n",
                     triangle_text(covariance.depth_intrinsics), triangle_text(covariance.T_depth_color));
}

}  // namespace meshloop
