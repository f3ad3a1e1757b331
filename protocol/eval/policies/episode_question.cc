#include "protocol/eval/policies/episode_question.h"

#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/batch/queries.h"
#include "protocol/eval/policies/choice_question.h"

namespace engram {
namespace {

// Keys of the items as they are listed.
std::vector<int> order_of(const Batch& batch, int index, const AnswerController& choices,
                          std::size_t items) {
  return choice_order(choices.choice_form(), batch.info().id, batch.state().seed[index],
                      choices.choices_made(index), items);
}

}  // namespace

void ask_questions(const Batch& batch, int index) {
  Queries(batch).running_answer_controller().await_answers(index);
}

JsonTable describe_question(const Batch& batch, int index) {
  const AnswerController& choices = Queries(batch).running_answer_controller();
  const ChoiceForm form = choices.choice_form();
  const std::vector<std::string> items = choices.choice_items(index);
  JsonList listed;
  for (const int key : order_of(batch, index, choices, items.size())) {
    listed.emplace_back(items[static_cast<std::size_t>(key)]);
  }
  return {{"due", choices.is_choice_due(index)},
          {"question", form.question},
          {"choices", std::move(listed)},
          {"least", form.least},
          {"most", form.most},
          {"repeats", form.repeats}};
}

void answer_question(const Batch& batch, int index, std::span<const int> answer) {
  const AnswerController& choices = Queries(batch).running_answer_controller();
  if (!choices.is_choice_due(index)) {
    throw Error(Error::kBadState, "no question is due in this environment");
  }
  const std::size_t items = choices.choice_items(index).size();
  choices.choice_form().check(answer, static_cast<int>(items));
  const std::vector<int> order = order_of(batch, index, choices, items);
  std::vector<int> keys;
  for (const int listed : answer) keys.push_back(order[static_cast<std::size_t>(listed)]);
  choices.choose(index, keys);
}

}  // namespace engram
