// Words of RotateLenient and RotateStrict: how the peg lay at first, and the turn to make.
#pragma once

#include "core/task/annotator.h"
#include "core/task/task.h"

namespace engram::tasks {

class RotateAnnotator final : public Annotator {
 public:
  // Privileged view of the task. The peg is its only prop.
  struct View {
    const Bindings& engine;
    const Column<double>& target;       // rad
    const Column<double>& initial_yaw;  // rad
    double threshold;                   // rad
    double peg_half_length;             // m
  };

  explicit RotateAnnotator(const View& view) : view_(view) {}

  std::vector<std::string> plan(int env) const override;
  int subtask(int env) const override;
  std::string memory(int env) const override;
  int object(int env) const override;

 private:
  View view_;
};

}  // namespace engram::tasks
