// Expert of BatteriesChecker: checks batteries one after another. Nothing is remembered between
// steps.
#pragma once

#include "core/task/answer_controller.h"
#include "core/task/expert.h"
#include "tasks/batteries_checker/check_columns.h"
#include "tasks/batteries_checker/params.h"
#include "tasks/batteries_checker/rack.h"
#include "tasks/common/press_button.h"

namespace engram::tasks {

class BatteryExpert final : public Expert, public AnswerController {
 public:
  // Privileged view of the task. Hidden: which batteries have been checked.
  struct View {
    const Bindings& engine;
    const TaskInfo& info;
    const BatteryParams& params;
    const BatteryRack& rack;
    const PressButton& button;
    const CheckColumns& check;
  };

  explicit BatteryExpert(const View& view) : view_(view) {}

  void act(Range envs, Script script, FloatRows actions) const override;
  // One question in every round.
  ChoiceForm choice_form() const override;
  std::vector<std::string> choice_items(int env) const override;
  bool is_choice_due(int env) const override;

 private:
  // What an agent does in one round.
  struct Plan {
    int battery = -1;        // to be tested, -1: none
    int active = -1;         // to be returned into its slot
    bool keep_down = false;  // the button, until the next round
  };

  // Writes the next action of a round that is in that stage.
  void play_round(int env, int stage, const Plan& plan, float* action) const;
  void insert(int env, int battery, float* action) const;
  // True once the battery stands in its slot and the tool is clear of it.
  bool put_back(int env, int battery, float* action) const;
  // True if nothing is between the fingers.
  bool clear_tool(int env, float* action) const;
  void press(int env, bool keep_down, float* action) const;
  void sweep(int env, float* action) const;
  int guess(int env) const;
  BatterySet all_batteries() const { return battery_bit(view_.params.ACTIVE_BATTERY_COUNT) - 1; }

  View view_;
};

}  // namespace engram::tasks
