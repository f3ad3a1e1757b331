// Expert of the Remember and Find-Imposter families: touches one object, or rests over one after
// the other.
#pragma once

#include "core/task/answer_controller.h"
#include "core/task/expert.h"
#include "tasks/common/phase_clock.h"
#include "tasks/common/touch_target.h"
#include "tasks/remember/object_set.h"

namespace engram::tasks {

class ObjectRecallExpert final : public Expert, public AnswerController {
 public:
  // Privileged view of the task. Objects are its first props, keys are indices.
  struct View {
    const Bindings& engine;
    const TaskInfo& info;
    const ObjectSet& objects;
    const PhaseClock& clock;
    const Column<std::int32_t>& target;  // hidden: key
    const Column<double>& positions;     // (3 per object) m, in the manipulation phase
    const TouchTarget& touch;
    double goal_thresh;  // m
  };

  explicit ObjectRecallExpert(const View& view) : view_(view) {}

  void act(Range envs, Script script, FloatRows actions) const override;
  ChoiceForm choice_form() const override;
  bool is_choice_due(int env) const override { return is_manipulation(env) && awaits_choice(env); }

 private:
  bool is_manipulation(int env) const {
    return view_.clock.phase(env, view_.engine.state->elapsed[env]) == Phase::kManipulation;
  }
  const double* position(int env, int key) const { return view_.positions.row(env) + 3 * key; }
  void touch(int env, int key, float* action) const;
  void sweep(int env, float* action) const;
  double touch_height(bool rolls) const;
  double sweep_reach() const;
  double gripper_for(int env, int key) const;
  bool is_crowded(int env, int key) const;
  int guess(int env) const;

  View view_;
};

}  // namespace engram::tasks
