// Words of Intercept and InterceptGrab.
#pragma once

#include "core/task/annotator.h"
#include "core/task/task.h"

namespace engram::tasks {

// The ball is the scene's first prop.
inline constexpr int kBallProp = 0;

// What has to be done with the ball.
enum class InterceptGoal { kDeflect, kGrab };

class InterceptAnnotator final : public Annotator {
 public:
  InterceptAnnotator(const Bindings& engine, InterceptGoal goal) : engine_(engine), goal_(goal) {}

  std::vector<std::string> plan(int env) const override;
  int subtask(int env) const override;
  // Nothing is hidden.
  std::string memory(int /*env*/) const override { return {}; }
  int object(int env) const override;

 private:
  const Bindings& engine_;
  InterceptGoal goal_;
};

}  // namespace engram::tasks
