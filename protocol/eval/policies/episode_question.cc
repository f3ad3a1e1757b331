#include "protocol/eval/policies/episode_question.h"

#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/batch/queries.h"
#include "protocol/eval/policies/choice_question.h"

namespace engram {
namespace {

// Keys of the items as they are listed.
std::vector<int> order_of(const Batch& env, int index, const Choices& choices, std::size_t items) {
  return choice_order(choices.choice_form(), env.info().id, env.state().seed[index],
                      choices.choices_made(index), items);
}

}  // namespace

void ask_questions(const Batch& env, int index) {
  Queries(env).running_choices().await_choices(index);
}

DocumentTable describe_question(const Batch& env, int index) {
  const Choices& choices = Queries(env).running_choices();
  const ChoiceForm form = choices.choice_form();
  const std::vector<std::string> items = choices.choice_items(index);
  DocumentList listed;
  for (const int key : order_of(env, index, choices, items.size())) {
    listed.emplace_back(items[static_cast<std::size_t>(key)]);
  }
  return {{"due", choices.is_choice_due(index)},
          {"question", form.question},
          {"choices", std::move(listed)},
          {"least", form.least},
          {"most", form.most},
          {"repeats", form.repeats}};
}

void answer_question(const Batch& env, int index, std::span<const int> answer) {
  const Choices& choices = Queries(env).running_choices();
  if (!choices.is_choice_due(index)) {
    throw Error(Error::kBadState, "no question is due in this environment");
  }
  const std::size_t items = choices.choice_items(index).size();
  choices.choice_form().check(answer, static_cast<int>(items));
  const std::vector<int> order = order_of(env, index, choices, items);
  std::vector<int> keys;
  for (const int listed : answer) keys.push_back(order[static_cast<std::size_t>(listed)]);
  choices.choose(index, keys);
}

}  // namespace engram
