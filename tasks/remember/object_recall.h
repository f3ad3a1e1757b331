// Base of the Remember and Find-Imposter families: objects of which some are shown, an empty
// table, then all objects, of which one has to be touched (docs/tasks/remember.md).
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/task/task.h"
#include "tasks/common/family_base.h"
#include "tasks/common/layout.h"
#include "tasks/common/phase_clock.h"
#include "tasks/common/random_variables.h"
#include "tasks/common/touch_target.h"
#include "tasks/registry.h"
#include "tasks/remember/annotator.h"
#include "tasks/remember/expert.h"
#include "tasks/remember/object_set.h"

namespace engram::tasks {

// Objects of a shape and a colour have no action cost.
constexpr SmoothnessParams default_smoothness(Vocabulary vocabulary) {
  if (vocabulary == Vocabulary::kShapeAndColor) return {};
  return {.ACTION_L2_COEF = 0.02, .ACTION_DELTA_L2_COEF = 0.05, .QVEL_L2_COEF = 0.01};
}

// items: the constant that is the number of objects.
constexpr MemoryFacts memory_facts(std::string_view items) {
  return {.irrelevant = CounterfactualChange::kDraw,
          .irrelevant_draw = "cue_steps",
          .delay = "EMPTY_PHASE_STEPS",
          .items = items};
}

// One row of a family's table.
struct ObjectRecallParams {
  TaskSpec task;
  ObjectSetParams objects;
  StepRange CUE_PHASE_STEPS;
  StepRange EMPTY_PHASE_STEPS;
  ArcParams arc = {};  // of the slots
  double GOAL_THRESH = tasks::GOAL_THRESH;
  // None: rewards know no action cost.
  std::optional<SmoothnessParams> smoothness = default_smoothness(objects.vocabulary);

  void declare(ConstantBinder& constants);
  void check(int horizon) const;
};

class ObjectRecall : public FamilyBase {
 public:
  void bind(const Bindings& bindings) override;
  int cue_end(int env) const override { return clock_.cue_end(env); }
  void sampled_values(int env, float* out) const override { write_sampled_values(*this, env, out); }
  void evaluate(Range envs) override;
  void dense_reward(Range envs, FloatRows out) override;
  void observe(Range envs, FloatRows out) override;
  const Expert& expert() const override { return expert_; }
  const Annotator* annotator() const override { return &annotator_; }
  void overlay(int env, Overlay& out) const override { objects_.overlay(target_[env], out); }

 protected:
  static constexpr double kHiddenHeight = 1000;  // reported while an object is hidden

  // Names and descriptions of a family's random variables.
  struct Wording {
    std::string target;       // name of the variable of the object to touch
    std::string target_text;  // that variable in words
    std::string positions_text;
    bool imposter = false;  // the cue shows all objects but the target
  };

  ObjectRecall(const RegistryEntry& entry, const ObjectRecallParams& params,
               const Wording& wording);

  const ObjectRecallParams& params() const { return params_; }
  const ObjectSet& objects() const { return objects_; }
  const PhaseClock& clock() const { return clock_; }
  int count() const { return params_.objects.count; }
  int target(int env) const { return target_[env]; }
  // Position of an object at rest in the manipulation phase, m.
  double* position(int env, int key) const { return positions_.row(env) + 3 * key; }

  // Counts a rest at the target as a success before the manipulation phase, too.
  void count_success_in_cue(bool counts) { success_in_cue_ = counts; }
  // Whether a touch needs a robot that stands still.
  void need_static(bool needed) { touch_.need_static(needed); }

  // Samples target and phase lengths.
  void begin_episode(const Episode& episode) const;
  // Samples the places of objects, by key: slots, jitter, permutation and guard, or the positions
  // that the user fixed. `spread`: three objects are spread and stretched.
  Layout draw_layout(const Episode& episode, bool spread) const;
  // Stores the places of the objects in the manipulation phase.
  void set_positions(int env, const Layout& layout) const;

 private:
  // Random variables of every episode; families add their own after these.
  struct Variables {
    Variables(RandomVariables list, const ObjectRecallParams& params, const Wording& wording);

    IntegerVariable target;
    VariableHandle positions;
    IntegerVariable cue_steps;
    IntegerVariable empty_steps;
  };

  const double* target_pos(int env) const { return engine_.state->prop_pos_of(env, target_[env]); }
  bool is_manipulation(int env) const {
    return clock_.phase(env, engine_.state->elapsed[env]) == Phase::kManipulation;
  }
  friend class FamilyBase;
  template <class Visitor>
  void state_row(Visitor& row, int env) const;
  template <class Visitor>
  void sampled_row(Visitor& row, int env) const {
    clock_.sampled_row(row, env);
  }
  void note_answer(int env) const;

  ObjectRecallParams params_;
  Variables variables_;
  ObjectSet objects_;
  Layout slots_;
  PhaseClock clock_;
  TouchTarget touch_;
  bool success_in_cue_ = false;
  Column<std::int32_t> target_;
  Column<double> positions_;  // (count * 3) m
  ObjectRecallExpert expert_;
  ObjectRecallAnnotator annotator_;
};

}  // namespace engram::tasks
