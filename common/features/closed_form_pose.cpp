#include "common/features/closed_form_pose.h"

#include <Eigen/Geometry>
#include <opencv2/calib3d.hpp>

namespace meshloop {
namespace {

cv::Matx33d matrix_of(const Camera& camera) {
  return {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1};
}

std::vector<Pose> to_poses(const std::vector<cv::Vec3d>& rotations, const std::vector<cv::Vec3d>& translations) {
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < rotations.size() && i < translations.size(); ++i) {
    const Eigen::Vector3d axis{rotations[i][0], rotations[i][1], rotations[i][2]};
    Pose pose = Pose::Identity();
    const double angle = axis.norm();
    if (angle > 0) pose.linear() = Eigen::AngleAxisd{angle, axis / angle}.toRotationMatrix();
    pose.translation() = Eigen::Vector3d{translations[i][0], translations[i][1], translations[i][2]};
    if (pose.matrix().allFinite()) poses.push_back(pose);
  }
  return poses;
}

template <std::size_t N>
std::vector<cv::Point2d> to_opencv(const std::array<Eigen::Vector2d, N>& pixels) {
  std::vector<cv::Point2d> converted;
  for (const Eigen::Vector2d& p : pixels) converted.emplace_back(p.x(), p.y());
  return converted;
}

}  // namespace

std::vector<Pose> poses_from_three(const std::array<Eigen::Vector3d, 3>& p_world,
                                   const std::array<Eigen::Vector2d, 3>& pixels, const Camera& camera) {
  std::vector<cv::Point3d> objects;
  for (const Eigen::Vector3d& p : p_world) objects.emplace_back(p.x(), p.y(), p.z());
  std::vector<cv::Vec3d> rotations;
  std::vector<cv::Vec3d> translations;
  cv::solveP3P(objects, to_opencv(pixels), matrix_of(camera), cv::noArray(), rotations, translations,
               cv::SOLVEPNP_AP3P);
  return to_poses(rotations, translations);
}

std::vector<Pose> poses_from_square(double side_m, const std::array<Eigen::Vector2d, 4>& pixels, const Camera& camera) {
  const double half = side_m / 2;
  const std::vector<cv::Point3d> objects{{-half, half, 0}, {half, half, 0}, {half, -half, 0}, {-half, -half, 0}};
  std::vector<cv::Vec3d> rotations;
  std::vector<cv::Vec3d> translations;
  cv::solvePnPGeneric(objects, to_opencv(pixels), matrix_of(camera), cv::noArray(), rotations, translations, false,
                      cv::SOLVEPNP_IPPE_SQUARE);
  return to_poses(rotations, translations);
}

}  // namespace meshloop
