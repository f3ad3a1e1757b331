#include "tasks/shell_game/expert.h"

#include "core/base/index.h"
#include "tasks/common/guess_stream.h"

namespace engram::tasks {

int ShellGameExpert::chosen_slot(int env, Script script) const {
  if (script == Script::kBlind && is_asked(env)) {
    return choice_or(env, [] { return kMiddleSlot; });
  }
  if (script != Script::kBlind || game_.is_answer_visible()) return game_.answer(env);
  RandomStream random = guess_stream(game_.engine(), env);
  return random.integer(0, kCups - 1);
}

ChoiceForm ShellGameExpert::choice_form() const {
  ChoiceForm form{.question = "Which cup is meant?"};
  for (int slot = 0; slot < kCups; ++slot) {
    form.items.push_back(std::string("the ") + kSlotNames[at(slot)] + " cup");
  }
  return form;
}

}  // namespace engram::tasks
