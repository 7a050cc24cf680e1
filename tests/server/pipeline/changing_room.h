#pragma once
// A room in which boxes come, go and shrink before a wall, and what a rig proposes from it.
#include <random>
#include <vector>

#include "common/simulation/scene.h"
#include "server/pipeline/adjuster.h"

namespace meshloop::test {

/// What stands in a changing room is what the model is adjusted to.
class ChangingRoom {
 public:
  explicit ChangingRoom(unsigned seed);

  /// The wall and what stands before it now, as nodes from this id on.
  [[nodiscard]] std::vector<Edit> model_from(NodeId id) const;
  /// A box comes, goes, or has another size; the next snapshot has another seed of noise and another view.
  void change();

  struct Look {
    TrackedFrame tracked;
    ProposedChanges changes;
  };
  /// A snapshot compared with the store's model, and what follows from it.
  [[nodiscard]] Look look(const SceneStore& store);
  [[nodiscard]] const Rig& rig() const { return rig_; }

 private:
  [[nodiscard]] simulation::Scene scene() const;

  std::mt19937 random_;
  Rig rig_;
  std::vector<bool> stands_;
  std::vector<double> side_m_;
  int looks_ = 0;
};

}  // namespace meshloop::test
