// Words of TraceShape and TraceShapeSeq: the shapes that were shown, and the one to trace.
#pragma once

#include "core/task/annotator.h"
#include "tasks/common/press_button.h"
#include "tasks/trace_shape/demo.h"

namespace engram::tasks {

class TraceAnnotator final : public Annotator {
 public:
  // Privileged view of the task.
  struct View {
    const Bindings& engine;
    const TraceDemo& demo;
    const Column<std::int32_t>& visited;           // bits of checkpoints
    const Column<std::int32_t>* closed = nullptr;  // of a sequence: contours that are closed
    const PressButton* button = nullptr;           // likewise
  };

  explicit TraceAnnotator(const View& view) : view_(view) {}

  std::vector<std::string> plan(int env) const override;
  int subtask(int env) const override;
  std::string memory(int env) const override;
  int object(int env) const override;

 private:
  bool is_sequence() const { return view_.closed != nullptr; }
  int closed(int env) const { return is_sequence() ? (*view_.closed)[env] : 0; }
  // Shapes whose demonstration is complete.
  int shown(int env) const;
  std::string shape_name(int env, int element) const;

  View view_;
};

}  // namespace engram::tasks
