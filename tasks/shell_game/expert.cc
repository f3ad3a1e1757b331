#include "tasks/shell_game/expert.h"

#include "tasks/common/guess_stream.h"

namespace engram::tasks {

int ShellGameExpert::chosen_slot(int env, Script script) const {
  if (script != Script::kBlind || game_.is_answer_visible()) return game_.answer(env);
  RandomStream random = guess_stream(game_.engine(), env);
  return random.integer(0, kCups - 1);
}

}  // namespace engram::tasks
