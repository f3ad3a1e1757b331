// Words of TakeItBack: where the cube has to be brought back to.
#pragma once

#include "core/task/annotator.h"
#include "core/task/task.h"

namespace engram::tasks {

class TakeItBackAnnotator final : public Annotator {
 public:
  // Privileged view of the task.
  struct View {
    const Bindings& engine;
    const Column<double>& initial;        // (2) m: where the cube started
    const Column<std::uint8_t>& reached;  // the cube has been on the target
  };

  explicit TakeItBackAnnotator(const View& view) : view_(view) {}

  std::vector<std::string> plan(int env) const override;
  int subtask(int env) const override;
  std::string memory(int env) const override;
  int object(int env) const override;

 private:
  View view_;
};

}  // namespace engram::tasks
