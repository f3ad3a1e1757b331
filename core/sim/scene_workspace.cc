#include "core/sim/scene_workspace.h"

namespace engram {

SceneWorkspace::SceneWorkspace(const PhysicsModel& model)
    : model_(&model), step_bench_(model.scenes()) {
  places_.reserve(model.scenes().size());
  for (const SceneModel& scene : model.scenes()) {
    places_.push_back({make_data_lazy_contacts(*scene.model), BroadPhase(*scene.model)});
    scene.kinematics.pose_fixed(*places_.back().data);
  }
}

void SceneWorkspace::reset_data() {
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const SceneModel& scene = model_->scenes()[i];
    mj_resetData(scene.model.get(), places_[i].data.get());
    scene.kinematics.pose_fixed(*places_[i].data);
    places_[i].owner = nullptr;
  }
}

}  // namespace engram
