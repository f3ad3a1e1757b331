#include "tasks/custom/annotator.h"

#include <algorithm>

namespace engram::tasks {

void CustomAnnotator::bind(ColumnStore& memory, Column<std::uint8_t> success) {
  const int last = static_cast<int>(about_.words.subtasks.size()) - 1;
  subtask_ = memory.add<std::int32_t>("subtask", 1, "", "the one of the plan that is to be done");
  memory.limit("subtask", 0, last);
  const ColumnView shown = memory.add({"shown", 1, DType::kBool, "", "the cue has been shown"});
  shown_ = Column<std::uint8_t>(reinterpret_cast<std::uint8_t*>(shown.data), 1);
  meant_ = memory.add<std::int32_t>("meant", 1, "", "prop that the subtask is about; -1: none");
  memory.limit("meant", -1, static_cast<int>(about_.props.size()) - 1);
  success_ = success;
}

std::vector<std::string> CustomAnnotator::plan(int env) const {
  std::vector<std::string> plan;
  for (const std::string& text : about_.words.subtasks) plan.push_back(filled(text, env));
  return plan;
}

int CustomAnnotator::subtask(int env) const {
  return std::clamp(subtask_[env], 0, static_cast<int>(about_.words.subtasks.size()) - 1);
}

int CustomAnnotator::subtasks_done(int env) const {
  return success_[env] != 0 ? static_cast<int>(about_.words.subtasks.size()) : subtask(env);
}

std::string CustomAnnotator::memory(int env) const {
  return shown_[env] != 0 ? filled(about_.words.memory, env) : "";
}

std::string CustomAnnotator::filled(const std::string& text, int env) const {
  return draws_.filled(text, env, [&](const std::string& name) {
    return name == about_.hidden && shown_[env] == 0 ? about_.words.unknown
                                                     : std::optional<std::string>();
  });
}

}  // namespace engram::tasks
