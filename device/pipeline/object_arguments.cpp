#include "device/pipeline/object_arguments.h"

#include "common/program/arguments.h"
#include "device/draw/demo_object.h"

namespace meshloop {

void ObjectArguments::add_to(CLI::App& command) {
  command.add_option("--object-at", position, "where the virtual object stands: X,Y,Z in the world, metres")
      ->delimiter(',')
      ->expected(3)
      ->check(between(-1e4, 1e4))
      ->capture_default_str();
  command.add_option("--object-up", up, "the world's direction in which it stands")
      ->delimiter(',')
      ->expected(3)
      ->check(between(-1e4, 1e4))
      ->capture_default_str();
  command.add_option("--object-height", height_m, "its height in metres")
      ->check(between(0.001, 10))
      ->capture_default_str();
}

Result<VirtualObject> ObjectArguments::make() const {
  const Eigen::Vector3d direction{up[0], up[1], up[2]};
  if (direction.norm() < 1e-9) return fail("--object-up takes a direction, such as 0,0,1", ErrorKind::usage);
  VirtualObject standing;
  standing.submesh = std::make_shared<const Submesh>(make_lighthouse(height_m));
  standing.T_world_object.linear() =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), direction).toRotationMatrix();
  standing.T_world_object.translation() = Eigen::Vector3d{position[0], position[1], position[2]};
  return standing;
}

}  // namespace meshloop
