// Base of the experts of all shell games.
#pragma once

#include "core/task/answer_controller.h"
#include "core/task/expert.h"
#include "tasks/shell_game/game.h"

namespace engram::tasks {

class ShellGameExpert : public Expert, public AnswerController {
 public:
  ChoiceForm choice_form() const override;
  bool is_choice_due(int env) const override {
    return game_.is_manipulation(env) && awaits_choice(env);
  }

 protected:
  explicit ShellGameExpert(const ShellGame& game) : game_(game) {}

  // Slot to go for: the answer, or a guess of the blind one.
  int chosen_slot(int env, Script script) const;

  const ShellGame& game_;  // a privileged view
};

}  // namespace engram::tasks
