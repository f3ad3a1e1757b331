// Experts of TraceShape and TraceShapeSeq: take the green cube and carry it low over the table,
// from one checkpoint to the next.
#pragma once

#include "core/task/answer_controller.h"
#include "core/task/expert.h"
#include "tasks/common/press_button.h"
#include "tasks/trace_shape/demo.h"

namespace engram::tasks {

// Base of both. Remembers which checkpoints of its own guess the blind expert has visited.
class TraceExpert : public Expert, public AnswerController {
 public:
  ChoiceForm choice_form() const override;
  double choice_chance() const override;
  bool is_choice_due(int env) const override { return demo_.is_acting(env) && awaits_choice(env); }
  // Adds the memory of the blind expert; for the task's bind.
  void bind(ColumnStore& memory);

 protected:
  TraceExpert(const Bindings& engine, const TraceDemo& demo) : engine_(engine), demo_(demo) {}

  const State& state() const { return *engine_.state; }
  // The demonstration as an agent guesses it that has not seen it; or as the caller has named its
  // shapes, as large and turned as they were shown.
  int guessed_length(int env) const;
  Contour guessed_contour(int env, int element) const;

  // Keeps the tool in place, as wide open as the cube.
  void await_demo(float* action) const;
  void trace(int env, const Contour& contour, int visited, float* action) const;
  // Leads the cube around rings that pass near every place where a contour may lead.
  void sweep_rings(int env, float* action) const;

  const Bindings& engine_;
  const TraceDemo& demo_;  // hidden: its contours
  Column<std::int32_t> guess_element_;
  Column<std::int32_t> guess_visited_;
};

class TraceShapeExpert final : public TraceExpert {
 public:
  // `visited`: bits of checkpoints.
  TraceShapeExpert(const Bindings& engine, const TraceDemo& demo,
                   const Column<std::int32_t>& visited)
      : TraceExpert(engine, demo), visited_(visited) {}

  void act(Range envs, Script script, FloatRows actions) const override;
  // Notes the progress of the blind expert. Once per step of the action phase.
  void follow_guess(int env, const Vec2& cube) const;

 private:
  const Column<std::int32_t>& visited_;
};

class TraceShapeSeqExpert final : public TraceExpert {
 public:
  // Privileged view of the task.
  struct View {
    const Bindings& engine;
    const TaskInfo& info;
    const TraceDemo& demo;
    const PressButton& button;
    const Column<std::int32_t>& active;   // contour that is to be traced
    const Column<std::int32_t>& visited;  // bits of its checkpoints
    const Column<std::int32_t>& closed;   // contours that are closed
  };

  explicit TraceShapeSeqExpert(const View& view)
      : TraceExpert(view.engine, view.demo), view_(view) {}

  void bind(ColumnStore& memory);
  void act(Range envs, Script script, FloatRows actions) const override;
  // Notes the progress of the blind expert. Once per step of the action phase.
  void follow_guess(int env, const Vec2& cube) const;

 private:
  void blind(int env, float* action) const;
  void sweep(int env, float* action) const;
  void submit(int env, float* action) const;

  View view_;
};

}  // namespace engram::tasks
