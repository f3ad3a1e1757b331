// Answers by name: those that an agent may give in an episode, and the scripted controller that
// carries out the one that the caller names.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/index.h"
#include "core/task/task.h"

namespace engram {

// Form of a task's questions; the same in all episodes.
struct ChoiceForm {
  std::string question = {};            // "Which cup hides the ball?"
  std::vector<std::string> items = {};  // texts of the items; empty: they are of an episode
  // Items of an answer, and whether one may come twice.
  int least = 1;
  int most = 1;
  bool repeats = false;
  int questions = 1;     // of an episode, at most
  bool ordered = false;  // items are listed in their own order, such as numbers

  // Throws Error, naming what is allowed, unless the answer has this form. keys: of `count` items.
  void check(std::span<const int> keys, int count) const;
};

// Beside Expert, a base of the experts that can carry out a caller's answer: with one,
// the blind script carries it out instead of its guess. Items have keys, from 0.
class AnswerController {
 public:
  virtual ~AnswerController() = default;

  virtual ChoiceForm choice_form() const = 0;
  // Success rate of guessing, uniform over the lengths of answers and then over the items; 0: the
  // task's.
  virtual double choice_chance() const { return 0; }
  // Texts of the items in an environment's episode, by key.
  virtual std::vector<std::string> choice_items(int /*env*/) const { return choice_form().items; }
  // True if the controller cannot go on in this step without an answer.
  virtual bool is_choice_due(int env) const = 0;

  // From now on an environment's controller waits for answers instead of guessing, until that is
  // taken back. Snapshots do not hold the answers.
  void await_answers(int env) const;
  void discard_answers(int env) const;
  // Answers a question; the keys must have been checked.
  void choose(int env, std::span<const int> keys) const;
  // Questions of an environment's episode that have been answered.
  int choices_made(int env) const {
    return is_asked(env) ? static_cast<int>(episodes_[at(env)]->size()) : 0;
  }

 protected:
  // True if the controller is to wait for the first answer.
  bool awaits_choice(int env) const { return is_asked(env) && episodes_[at(env)]->empty(); }
  bool is_asked(int env) const {
    return at(env) < episodes_.size() && episodes_[at(env)].has_value();
  }
  // Keys of an answer; empty if there is none.
  std::span<const int> choice(int env, int number = 0) const;
  // The only key of the first answer, or `guess()` where no answers are awaited.
  template <class Guess>
  int choice_or(int env, Guess guess) const {
    const std::span<const int> keys = choice(env);
    return keys.empty() ? guess() : keys.front();
  }

 private:
  // Answers of each environment's episode, in order; unset where none are awaited. As with columns,
  // tasks are not const inside.
  mutable std::vector<std::optional<std::vector<std::vector<int>>>> episodes_;
};

// The choices of a task; null if its answers have no names, or if there is one alone.
const AnswerController* answer_controller_of(Task& task);

}  // namespace engram
