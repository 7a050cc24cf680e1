#pragma once
// The parts of rig.yaml that say how far its other numbers and the depths are to be trusted. Private to this room.
#include <yaml-cpp/yaml.h>

#include <string>

#include "common/base/result.h"
#include "common/geometry/rig.h"

namespace meshloop {

/// A name, {constant: METRES}, or {polynomial: [c0, c1, c2], range: [near, far], step: S, lateral_px: L}.
[[nodiscard]] Result<SensorModel> parse_sensor(const YAML::Node& node);
/// What parse_sensor reads again.
[[nodiscard]] std::string sensor_text(const SensorModel& sensor);

/// {depth_intrinsics: [10 numbers], T_depth_color: [21 numbers]}, each the upper triangle row by row; what is left out
/// is exact.
[[nodiscard]] Result<CalibrationCovariance> parse_covariance(const YAML::Node& node);
/// A line of rig.yaml; empty when all is exact.
[[nodiscard]] std::string covariance_text(const CalibrationCovariance& covariance);

}  // namespace meshloop
