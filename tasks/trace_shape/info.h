// Descriptions of TraceShape and TraceShapeSeq.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/task/task.h"
#include "tasks/trace_shape/demo.h"

namespace engram::tasks {

// TaskInfo::phases; `demo_end` is the formula of that step.
std::vector<std::pair<std::string, std::string>> trace_phases(const std::string& demo_end);

// Random variable that an agent has to remember first of all: the first that is not always the
// same.
std::string hidden_variable(const TraceParams& params);

// Info fields that name the phase.
class TraceMasks {
 public:
  void bind(ColumnStore& info) {
    action_ = info.add<std::uint8_t>("action_mask", 1, "", "the action phase");
    demo_ = info.add<std::uint8_t>("demo_mask", 1, "", "the demonstration");
    pre_demo_ = info.add<std::uint8_t>("pre_demo_mask", 1, "", "before the demonstration");
  }
  void show(int env, TracePhase phase) const {
    action_[env] = phase == TracePhase::kAction ? 1 : 0;
    demo_[env] = phase == TracePhase::kDemo ? 1 : 0;
    pre_demo_[env] = phase == TracePhase::kPreDemo ? 1 : 0;
  }

 private:
  Column<std::uint8_t> action_;
  Column<std::uint8_t> demo_;
  Column<std::uint8_t> pre_demo_;
};

}  // namespace engram::tasks
