// What one thread computes scenes on: MuJoCo's data of every compiled scene,
// and the memory of the solver. Environments that are
// stepped side by side take turns.
#pragma once

#include <vector>

#include "core/physics/composed_step.h"
#include "core/physics/model.h"
#include "core/physics/pair_sieve.h"

namespace engram {

class SceneBench {
 public:
  struct Place {
    DataPtr data;
    PairSieve sieve;
    const void* owner = nullptr;  // whose props are loaded
  };

  explicit SceneBench(const PhysicsModel& model);

  const PhysicsModel& model() const { return *model_; }
  StepBench& step_bench() { return step_bench_; }
  Place& place(int scene) { return places_[static_cast<std::size_t>(scene)]; }

  // Makes all data as good as new, after a step that diverged.
  void reset_data();

 private:
  const PhysicsModel* model_;
  std::vector<Place> places_;  // of every compiled scene
  StepBench step_bench_;
};

}  // namespace engram
