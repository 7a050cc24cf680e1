#pragma once
// Where in the world the pictures keep contradicting the model: what was moved there or put in front of it since it was
// made. What was taken away and left a plain surface shows nothing that could contradict.
#include <Eigen/Core>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace meshloop {

/// What one observation says about the model at a world point, at a pose that is right.
struct Verdict {
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
  bool agrees = false;
};

/// Cubes of four centimetres, each with the mean verdict on what lies in it, in which new frames count more than old
/// ones. A place is stale after several frames in which little agreed, and no longer after several in which most did.
/// One thread.
class StalePlaces {
 public:
  /// The verdicts of one frame. The pose that they rest on must be sure without what lies at stale places: of a wrong
  /// pose everything else would become stale.
  void judge(const std::vector<Verdict>& verdicts);
  [[nodiscard]] bool contains(const Eigen::Vector3d& p_world) const;
  void clear() { places_.clear(); }

 private:
  struct Place {
    /// 0 (everything contradicts) to 1.
    double agreement = 1;
    int frames = 0;
    bool stale = false;
  };
  std::unordered_map<std::uint64_t, Place> places_;
};

}  // namespace meshloop
