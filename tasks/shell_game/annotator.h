// Words of the shell games: where the ball, or the ball of the lamp's colour, is.
#pragma once

#include "core/task/annotator.h"
#include "tasks/shell_game/lamp_cue.h"
#include "tasks/shell_game/shuffle_phase.h"

namespace engram::tasks {

class ShellGameAnnotator final : public Annotator {
 public:
  // What has to be done with the mug.
  enum class Skill { kTouch, kPush, kPick };

  // Privileged view of the game.
  struct View {
    const ShellGame& game;
    Skill skill = Skill::kTouch;
    int ball = -1;                          // prop, where there is one ball
    const LampCue* lamp = nullptr;          // where there are three
    const ShufflePhase* shuffle = nullptr;  // where mugs change places
  };

  explicit ShellGameAnnotator(const View& view) : view_(view) {}

  std::vector<std::string> plan(int env) const override;
  int subtask(int env) const override;
  std::string memory(int env) const override;
  int object(int env) const override;

 private:
  // A mug, which is named by its first slot.
  int mug(int env) const;
  bool is_cue(int env) const;
  // Slot of a mug in the end.
  int final_slot(int env, int mug) const;
  std::string cup_words(int env) const;
  std::string balls(int env, bool at_the_end) const;
  std::vector<std::string> skill_subtasks(const std::string& cup) const;
  int skill_subtasks_done(int env) const;

  View view_;
};

}  // namespace engram::tasks
