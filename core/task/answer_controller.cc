#include "core/task/answer_controller.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/index.h"
#include "core/task/expert.h"

namespace engram {

void ChoiceForm::check(std::span<const int> keys, int count) const {
  const auto refuse = [](const std::string& what) { throw Error(Error::kInvalidArgument, what); };
  const auto size = static_cast<int>(keys.size());
  if (size < least || size > most) {
    refuse(std::to_string(size) + " choices given, " + std::to_string(least) +
           (most > least ? " to " + std::to_string(most) : "") + " needed");
  }
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i] < 0 || keys[i] >= count) {
      refuse("choice " + std::to_string(keys[i]) + " given, 0 to " + std::to_string(count - 1) +
             " allowed");
    }
    if (!repeats && std::ranges::count(keys, keys[i]) > 1) {
      refuse("choice " + std::to_string(keys[i]) + " given twice, once allowed");
    }
  }
}

void AnswerController::await_answers(int env) const {
  if (at(env) >= episodes_.size()) episodes_.resize(at(env) + 1);
  episodes_[at(env)].emplace();
}

void AnswerController::discard_answers(int env) const {
  if (is_asked(env)) episodes_[at(env)].reset();
}

void AnswerController::choose(int env, std::span<const int> keys) const {
  episodes_.at(at(env)).value().emplace_back(keys.begin(), keys.end());
}

std::span<const int> AnswerController::choice(int env, int number) const {
  if (number < 0 || number >= choices_made(env)) return {};
  return (*episodes_[at(env)])[at(number)];
}

const AnswerController* answer_controller_of(Task& task) {
  const bool custom = task.batch_task() != nullptr;
  const auto* choices = custom ? dynamic_cast<const AnswerController*>(&task)
                               : dynamic_cast<const AnswerController*>(&task.expert());
  if (choices == nullptr) return nullptr;
  const ChoiceForm form = choices->choice_form();
  if (custom && form.items.empty()) return nullptr;
  return form.items.size() == 1 && form.most == 1 ? nullptr : choices;
}

}  // namespace engram
