// Expert of TakeItBack: grasps the cube, carries it to the target and back.
#pragma once

#include <Eigen/Core>

#include "core/task/answer_controller.h"
#include "core/task/expert.h"

namespace engram::tasks {

class TakeItBackExpert final : public Expert, public AnswerController {
 public:
  // Privileged view of the task.
  struct View {
    const Bindings& engine;
    const Column<double>& initial;     // hidden: (2) m
    const Column<std::int32_t>& slot;  // hidden: of the initial place
    const Column<double>& goal;        // (2) m
    const Column<std::uint8_t>& reached;
    double goal_radius;    // m
    double cube_halfsize;  // m
  };

  explicit TakeItBackExpert(const View& view) : view_(view) {}

  void act(Range envs, Script script, FloatRows actions) const override;
  ChoiceForm choice_form() const override;
  bool is_choice_due(int env) const override;

 private:
  // The cube has been on the target, which shows that.
  bool is_to_return(int env) const;
  Eigen::Vector2d home(int env, Script script) const;
  Eigen::Vector2d chosen_home(int env) const;
  bool is_beside_way(int env, const Eigen::Vector2d& place) const;
  Eigen::Vector2d neutral_way(int env) const;
  void grasp_cube(int env, bool let_go, float* action) const;
  void carry_cube(int env, const Eigen::Vector2d& home, float* action) const;

  View view_;
};

}  // namespace engram::tasks
