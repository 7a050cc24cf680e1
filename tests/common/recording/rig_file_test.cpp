#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/file.h"
#include "common/recording/recording.h"
#include "recordings.h"
#include "temporary_folder.h"

namespace meshloop {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// Every key that common/recording/README.md lists.
constexpr const char* kExample = R"(
color: {width: 640, height: 480, fx: 525.0, fy: 525.0, cx: 319.5, cy: 239.5, distortion: [0.1, -0.2, 0.001, 0.002, 0.3]}
depth: {width: 320, height: 240, fx: 285.0, fy: 285.0, cx: 159.5, cy: 119.5, distortion: [0, 0, 0, 0, 0]}
depth_scale: 0.001            # metres per unit of the 16-bit depth image
T_depth_color: {translation: [-0.025, 0, 0.001], rotation_xyzw: [0, 0, 0, 1]}
sensor: kinect1               # noise model
depth_registered: false       # true: depth already lies in the colour camera's pixels
)";

class RigFile : public testing::Test {
 protected:
  Result<Rig> read(const std::string& text) {
    EXPECT_TRUE(write_text_file(file_, text));
    return read_rig(file_);
  }
  std::string error_of(const std::string& from, const std::string& to) {
    const auto rig = read(replaced(kExample, from, to));
    return rig ? "no error" : rig.error().message;
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "rig.yaml";
};

TEST_F(RigFile, ReadsTheDocumentedExample) {
  const auto rig = read(kExample);
  ASSERT_TRUE(rig) << rig.error().message;
  EXPECT_EQ(rig->color.width, 640);
  EXPECT_EQ(rig->color.distortion, (std::array{0.1, -0.2, 0.001, 0.002, 0.3, 0.0, 0.0, 0.0}));
  EXPECT_EQ(rig->depth.cy, 119.5);
  EXPECT_EQ(rig->depth_scale, 0.001);
  EXPECT_EQ(rig->T_depth_color.translation(), Eigen::Vector3d(-0.025, 0, 0.001));
  EXPECT_EQ(rig->sensor.kind(), SensorModel::Kind::kinect1);
  EXPECT_FALSE(rig->depth_registered);
}

TEST_F(RigFile, RotationIsReadAsXyzwFromColorToDepth) {
  const auto rig = read(replaced(kExample, "[0, 0, 0, 1]", "[0, 0, 0.70710678118654752, 0.70710678118654752]"));
  ASSERT_TRUE(rig);
  EXPECT_TRUE((rig->T_depth_color.linear() * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY(), 1e-12));
}

TEST_F(RigFile, WrittenNumbersComeBackToTheBit) {
  for (const auto& sensor :
       {SensorModel{}, SensorModel{SensorModel::Kind::tof}, SensorModel::constant(0.1 / 3).value()}) {
    Rig rig = small_rig();
    rig.sensor = sensor;
    ASSERT_TRUE(write_rig(file_, rig));
    const auto read = read_rig(file_);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->color.fy, rig.color.fy);
    EXPECT_EQ(read->color.distortion, rig.color.distortion);
    EXPECT_EQ(read->depth.fy, rig.depth.fy);
    EXPECT_EQ(read->depth_scale, rig.depth_scale);
    EXPECT_EQ(read->T_depth_color.translation(), rig.T_depth_color.translation());
    EXPECT_TRUE(read->T_depth_color.isApprox(rig.T_depth_color, 1e-15));
    EXPECT_EQ(read->sensor.kind(), sensor.kind());
    EXPECT_EQ(read->sensor.constant_m(), sensor.constant_m());
  }
}

TEST_F(RigFile, MeasuredSensorComesBackToTheBit) {
  SensorNoise noise;
  noise.axial = {0.0011, -0.0007, 0.1 / 37};
  noise.nearest_m = 0.55;
  noise.farthest_m = 3.1;
  noise.step_per_m = 0.00285;
  noise.lateral_px = 0.77;
  Rig rig = small_rig();
  rig.sensor = SensorModel::measured(noise).value();
  ASSERT_TRUE(write_rig(file_, rig));
  const auto read = read_rig(file_);
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->sensor.kind(), SensorModel::Kind::measured);
  EXPECT_EQ(read->sensor.noise().axial, noise.axial);
  EXPECT_EQ(read->sensor.noise().nearest_m, 0.55);
  EXPECT_EQ(read->sensor.noise().farthest_m, 3.1);
  EXPECT_EQ(read->sensor.noise().step_per_m, 0.00285);
  EXPECT_EQ(read->sensor.noise().lateral_px, 0.77);
}

TEST_F(RigFile, MeasuredSensorThatCannotBeIsRefused) {
  const auto error = [&](const char* polynomial, const char* range, const char* rest) {
    return error_of("sensor: kinect1",
                    std::string{"sensor: {polynomial: "} + polynomial + ", range: " + range + ", " + rest + "}");
  };
  const char* good = "step: 0, lateral_px: 1";
  EXPECT_EQ(error("[0.001, 0, 0]", "[0.5, 2]", good), "no error");
  EXPECT_THAT(error("[0.001, 0]", "[0.5, 2]", good), HasSubstr("'sensor.polynomial' must be a list of 3"));
  EXPECT_THAT(error("[0.001, -0.001, 0]", "[0.5, 2]", good), HasSubstr("must be above 0"));
  // Positive at both ends, not between them.
  EXPECT_THAT(error("[0.0009, -0.002, 0.001]", "[0.5, 2]", good), HasSubstr("must be above 0"));
  EXPECT_THAT(error("[0.001, 0, 0]", "[2, 0.5]", good), HasSubstr("from near to far"));
  EXPECT_THAT(error("[0.001, 0, 0]", "[0.5, 2]", "step: 1, lateral_px: 1"), HasSubstr("step"));
  EXPECT_THAT(error("[0.001, 0, 0]", "[0.5, 2]", "step: 0, lateral_px: -1"), HasSubstr("lateral"));
  EXPECT_THAT(error("[0.001, 0, 0]", "[0.5, 2]", "step: 0"), HasSubstr("'sensor.lateral_px' is missing"));
}

TEST_F(RigFile, CovarianceIsOptionalAndComesBackToTheBit) {
  EXPECT_TRUE(read(kExample)->covariance.depth_intrinsics.isZero(0));
  Rig rig = small_rig();
  Eigen::Matrix4d A = Eigen::Matrix4d::Random();
  Eigen::Matrix<double, 6, 6> B = Eigen::Matrix<double, 6, 6>::Random();
  rig.covariance.depth_intrinsics = A * A.transpose();
  rig.covariance.T_depth_color = 1e-6 * B * B.transpose();
  ASSERT_TRUE(write_rig(file_, rig));
  const auto back = read_rig(file_);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_TRUE(back->covariance.depth_intrinsics.isApprox(rig.covariance.depth_intrinsics, 1e-15));
  EXPECT_TRUE(back->covariance.T_depth_color.isApprox(rig.covariance.T_depth_color, 1e-15));
  const auto one = read(std::string{kExample} + "covariance: {depth_intrinsics: [4, 1, 0, 0, 5, 0, 0, 6, 0, 7]}\n");
  ASSERT_TRUE(one) << one.error().message;
  EXPECT_EQ(one->covariance.depth_intrinsics(1, 0), 1);
  EXPECT_EQ(one->covariance.depth_intrinsics(3, 3), 7);
  EXPECT_TRUE(one->covariance.T_depth_color.isZero(0));
}

TEST_F(RigFile, CovarianceThatIsNoneIsRefused) {
  const auto error = [&](const std::string& line) {
    const auto rig = read(kExample + line + "\n");
    return rig ? "no error" : rig.error().message;
  };
  EXPECT_THAT(error("covariance: {depth_intrinsics: [1, 2]}"), HasSubstr("must be a list of 10 numbers"));
  EXPECT_THAT(error("covariance: {color: [1, 2]}"), HasSubstr("unknown key 'covariance.color'"));
  EXPECT_THAT(error("covariance: {depth_intrinsics: [1, 2, 0, 0, 1, 0, 0, 1, 0, 1]}"),
              HasSubstr("negative eigenvalue"));
  EXPECT_THAT(error("covariance: {depth_intrinsics: [-1, 0, 0, 0, 1, 0, 0, 1, 0, 1]}"),
              HasSubstr("negative eigenvalue"));
}

TEST_F(RigFile, ARationalLensHasEightCoefficients) {
  const auto rig = read(replaced(kExample, "[0, 0, 0, 0, 0]", "[0.6, 0.3, 0, 0, 0.05, 0.9, 0.4, 0.1]"));
  ASSERT_TRUE(rig) << rig.error().message;
  EXPECT_EQ(rig->depth.distortion, (std::array{0.6, 0.3, 0.0, 0.0, 0.05, 0.9, 0.4, 0.1}));
  ASSERT_TRUE(write_rig(file_, *rig));
  EXPECT_EQ(read_rig(file_)->depth.distortion, rig->depth.distortion);
  const auto text = read_text_file(file_, 10'000);
  ASSERT_TRUE(text);
  EXPECT_THAT(*text, HasSubstr("distortion: [0.1, -0.2, 0.001, 0.002, 0.3]"));  // the plain one stays plain
  EXPECT_THAT(error_of("[0, 0, 0, 0, 0]", "[0, 0, 0, 0, 0, 0, 0]"), HasSubstr("5 or 8"));
}

TEST_F(RigFile, EveryMissingKeyIsNamedWithTheFile) {
  for (const char* key : {"depth_scale", "T_depth_color", "sensor", "depth_registered", "color", "depth"}) {
    std::string text = kExample;
    const auto start = text.find(std::string{"\n"} + key + ":") + 1;
    text.erase(start, text.find('\n', start) - start);
    const auto rig = read(text);
    ASSERT_FALSE(rig) << key;
    EXPECT_THAT(rig.error().message,
                AllOf(HasSubstr(file_.string()), HasSubstr(std::string{"'"} + key + "' is missing")));
  }
  EXPECT_THAT(error_of("fx: 525.0, ", ""), HasSubstr("'color.fx' is missing"));
  EXPECT_THAT(error_of(", rotation_xyzw: [0, 0, 0, 1]", ""), HasSubstr("'T_depth_color.rotation_xyzw' is missing"));
}

TEST_F(RigFile, UnknownAndRepeatedKeysAreRefusedWithAHint) {
  EXPECT_THAT(error_of("depth_scale", "depthscale"),
              AllOf(HasSubstr("unknown key 'depthscale'"), HasSubstr("depth_scale")));
  EXPECT_THAT(error_of("fy: 285.0", "fz: 285.0"), AllOf(HasSubstr("'depth.fz'"), HasSubstr("fy")));
  EXPECT_THAT(error_of("sensor: kinect1", "sensor: {sigma: 1}"),
              AllOf(HasSubstr("'sensor.sigma'"), HasSubstr("constant")));
  EXPECT_THAT(error_of("sensor: kinect1", "sensor: tof\nsensor: tof"), HasSubstr("'sensor' stands there twice"));
}

TEST_F(RigFile, WrongTypesAndNumbersNameTheKey) {
  EXPECT_THAT(error_of("width: 640", "width: 640.5"), HasSubstr("'color.width' must be a whole number, not '640.5'"));
  EXPECT_THAT(error_of("fx: 525.0", "fx: .nan"), HasSubstr("'color.fx' must be a finite number"));
  EXPECT_THAT(error_of("fx: 525.0", "fx: [1]"), HasSubstr("'color.fx' must be a number"));
  EXPECT_THAT(error_of("fx: 525.0", "fx: -525.0"), HasSubstr("color: fx and fy must be positive"));
  EXPECT_THAT(error_of("width: 640", "width: 9000"), HasSubstr("9000x480"));
  EXPECT_THAT(error_of("[0, 0, 0, 0, 0]", "[0, 0, 0, 0]"),
              HasSubstr("'depth.distortion' must be a list of 5 or 8 numbers"));
  EXPECT_THAT(error_of("[0, 0, 0, 0, 0]", "[0, 0, a, 0, 0]"), HasSubstr("'depth.distortion[2]'"));
  EXPECT_THAT(error_of("depth_scale: 0.001", "depth_scale: 0"), HasSubstr("depth_scale must be positive"));
  EXPECT_THAT(error_of("[0, 0, 0, 1]", "[0, 0, 0, 1.1]"), HasSubstr("must have length 1"));
  EXPECT_THAT(error_of("[0, 0, 0, 1]", "[0, 0, 0, 0]"), HasSubstr("must have length 1"));
  EXPECT_THAT(error_of("sensor: kinect1", "sensor: kinect9"), HasSubstr("unknown sensor 'kinect9'"));
  EXPECT_THAT(error_of("sensor: kinect1", "sensor: {constant: 5}"), HasSubstr("below 1 m"));
  EXPECT_THAT(error_of("depth_registered: false", "depth_registered: 7"), HasSubstr("must be true or false"));
}

TEST_F(RigFile, ARegisteredDepthCameraMustBeTheColorCamera) {
  EXPECT_THAT(error_of("depth_registered: false", "depth_registered: true"), HasSubstr("must repeat the numbers"));
  Rig rig = small_rig();
  rig.depth = rig.color;
  rig.depth_registered = true;
  EXPECT_THAT(write_rig(file_, rig).error().message, HasSubstr("must be the identity"));
  rig.T_depth_color = Pose::Identity();
  ASSERT_TRUE(write_rig(file_, rig));
  EXPECT_TRUE(read_rig(file_)->depth_registered);
  rig.covariance.T_depth_color = 1e-6 * PoseCovariance::Identity();
  EXPECT_THAT(write_rig(file_, rig).error().message, HasSubstr("leave its covariance out"));
}

TEST_F(RigFile, WhatIsNotYamlOrNotAMapIsOneSentence) {
  EXPECT_THAT(read("color: {width: 640").error().message,
              AllOf(HasSubstr("rig.yaml', line"), HasSubstr("is not YAML")));
  EXPECT_THAT(read("").error().message, HasSubstr("'key: value' lines"));
  EXPECT_THAT(read("- 1\n- 2\n").error().message, HasSubstr("'key: value' lines"));
  EXPECT_FALSE(read(std::string(1000, '[')));
  EXPECT_FALSE(read(std::string("\0\xff\xfe", 3)));
  EXPECT_FALSE(read("a: &a [*a]"));
  EXPECT_THAT(read(std::string(2u << 20, '#')).error().message, HasSubstr("too large"));
}

}  // namespace
}  // namespace meshloop
