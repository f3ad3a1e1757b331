#include "protocol/eval/run/choice_tasks.h"

#include <algorithm>

#include "core/base/join.h"
#include "core/batch/scripted_policy.h"
#include "core/task/answer_controller.h"

namespace engram {
namespace {

bool has_choices(std::string_view id) { return answer_controller_of(*make_task(id)) != nullptr; }

// Tasks with choices: families where all have, ids of the others.
std::string tasks_with_choices() {
  struct Tasks {
    std::vector<std::string> ids;
    bool all = true;
  };
  std::vector<std::pair<std::string, Tasks>> families;
  for (const RegistryEntry& entry : registry()) {
    const auto named = [&](const auto& family) { return family.first == entry.family; };
    auto found = std::ranges::find_if(families, named);
    if (found == families.end()) {
      found = families.insert(found, {std::string(entry.family), Tasks()});
    }
    if (has_choices(entry.id)) {
      found->second.ids.emplace_back(entry.id);
    } else {
      found->second.all = false;
    }
  }
  std::vector<std::string> whole;
  std::vector<std::string> single;
  for (auto& [family, tasks] : families) {
    if (tasks.all) whole.push_back(family);
    if (!tasks.all) single.insert(single.end(), tasks.ids.begin(), tasks.ids.end());
  }
  return "all tasks of " + join(whole) + " and " + join(single);
}

}  // namespace

void require_choices(const EvaluationSettings& settings) {
  require_mode_of(Policy::kBlind, settings.control_mode);
  if (settings.latency > 0) {
    throw Error(Error::kInvalidArgument,
                "choices with a latency of " + std::to_string(settings.latency) +
                    " steps given, 0 allowed: the hand waits for the answer");
  }
  for (const std::string& id : settings.tasks) {
    const std::unique_ptr<Task> task = make_task(id, settings.constants);
    const AnswerController* choices = answer_controller_of(*task);
    if (choices == nullptr) {
      throw Error(Error::kInvalidArgument,
                  id + " has no list of answers to choose from; " + tasks_with_choices() + " have");
    }
    const std::vector<std::string> items = choices->choice_form().items;
    for (const std::string& item : items) {
      if (std::ranges::count(items, item) == 1) continue;
      throw Error(Error::kInvalidArgument, std::string(id)
                                               .append(": two answers are '")
                                               .append(item)
                                               .append("'; constants that tell them apart needed"));
    }
  }
}

}  // namespace engram
