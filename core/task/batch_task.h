// A task that is called for many environments at once, instead of for ranges on several threads:
// for tasks that are written in another language.
#pragma once

#include <span>

#include "core/task/expert.h"
#include "core/task/task.h"

namespace engram {

// All calls come from the thread that steps or resets the batch, between the parts that its worker
// threads share. Environments are listed in ascending order. What a call throws ends the step or
// the reset; the batch then has to be reset as a whole.
class BatchTask {
 public:
  virtual ~BatchTask() = default;

  // Behind Task::reset, which has been called for each of them.
  virtual void reset(std::span<const int> envs) = 0;
  // False: before_physics does nothing.
  virtual bool moves_before_physics() const = 0;
  // The methods of Task, with the same meaning.
  virtual void before_physics(std::span<const int> envs) = 0;
  virtual void advance(std::span<const int> envs) = 0;
  virtual void evaluate(std::span<const int> envs) = 0;
  virtual void observe(std::span<const int> envs, FloatRows out) = 0;
  virtual void dense_reward(std::span<const int> envs, FloatRows out) = 0;
  // Actions of the expert's script.
  virtual void act(std::span<const int> envs, Script script, FloatRows actions) = 0;
};

}  // namespace engram
