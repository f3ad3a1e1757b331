// Words of BatteriesCheckerEasy and BatteriesCheckerHard: which batteries have been checked, and
// with which result.
#pragma once

#include "core/task/annotator.h"
#include "tasks/batteries_checker/check_columns.h"
#include "tasks/batteries_checker/rack.h"
#include "tasks/common/press_button.h"

namespace engram::tasks {

class BatteryAnnotator final : public Annotator {
 public:
  // Privileged view of the task.
  struct View {
    const BatteryParams& params;
    const BatteryRack& rack;
    const PressButton& button;
    const CheckColumns& check;
  };

  explicit BatteryAnnotator(const View& view) : view_(view) {}

  std::vector<std::string> plan(int env) const override;
  int subtask(int env) const override;
  int subtasks_done(int env) const override;
  std::string memory(int env) const override;
  int object(int env) const override;

 private:
  // Subtasks of a check: insert, with Hard return, confirm.
  int per_battery() const { return view_.params.easy ? 2 : 3; }
  int done_of_check(int env) const;
  int battery(int env) const;

  View view_;
};

}  // namespace engram::tasks
