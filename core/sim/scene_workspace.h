// What one thread computes scenes on: MuJoCo's data of every compiled scene,
// and the memory of the solver. Environments that are
// stepped side by side take turns.
#pragma once

#include <vector>

#include "core/contact/broad_phase.h"
#include "core/contact/contact_step.h"
#include "core/scene/physics_model.h"

namespace engram {

class SceneWorkspace {
 public:
  struct Place {
    DataPtr data;
    BroadPhase sieve;
    const void* owner = nullptr;  // whose props are loaded
  };

  explicit SceneWorkspace(const PhysicsModel& model);

  const PhysicsModel& model() const { return *model_; }
  ContactWorkspace& contact_workspace() { return step_bench_; }
  Place& place(int scene) { return places_[static_cast<std::size_t>(scene)]; }

  // Makes all data as good as new, after a step that diverged.
  void reset_data();

 private:
  const PhysicsModel* model_;
  std::vector<Place> places_;  // of every compiled scene
  ContactWorkspace step_bench_;
};

}  // namespace engram
