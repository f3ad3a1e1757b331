// Rule of the games in which a mug is touched: the TCP comes within GOAL_THRESH of the right mug
// and the robot stands still, with or without contact.
#pragma once

#include "tasks/shell_game/game.h"
#include "tasks/shell_game/touch_params.h"

namespace engram::tasks {

class TouchRule {
 public:
  // Name of a term of reward_dict in some games.
  static constexpr const char* kPlacedInfo = "info[\"is_obj_placed\"]";
  struct Form {
    bool shoving = false;  // info shows how far mugs were shoved, and success depends on it
    const char* placed_term = "is_obj_placed";  // in reward_dict
  };
  // Dense reward (tasks/common/reward_dict.h): 0 outside the manipulation phase, 3 at success.
  struct Reward {
    double distance = 0;      // TCP to goal, m
    double arm_speed = 0;     // rad/s
    double displacement = 0;  // farthest that a mug was shoved, m
    bool robot_static = false;
    bool placed = false;
    bool manipulation = false;
    bool success = false;
    Form form = {};
    // Terms.
    double reaching = 0;
    double stillness = 0;
    double shift = 0;

    double compute();
    template <class Visitor>
    void list_terms(Visitor& row) const {
      row.term("reaching_reward", "", reaching);
      row.term("static_reward", "", stillness);
      row.term("tcp_to_obj_dist", "m", distance);
      if (form.shoving) {
        row.term("mug_max_displacement", "m", displacement);
        row.term("mug_shift_penalty", "", shift);
        row.term("is_mug_displacement_ok", "", meets_extra_condition(displacement));
      }
      row.term(form.placed_term, "", placed);
    }
  };

  // Class constants of the games in which mugs may be shoved.
  static void declare(ConstantBinder& constants);

  TouchRule(const TouchParams& params, const Form& form)
      : goal_thresh_(params.GOAL_THRESH), form_(form) {}

  bool is_shoving() const { return form_.shoving; }

  // Adds reward terms and the meaning of an answer.
  void describe(TaskInfo& info) const;
  void bind(const Bindings& bindings);

  // Success of a TCP at the goal, with mugs that were shoved by at most `displacement` m.
  ShellGame::Outcome judge(const ShellGame& game, int env, const Eigen::Vector3d& goal,
                           double displacement = 0) const;
  // The mug that is touched in the manipulation phase, the nearest one if there are several; -1:
  // none.
  int touched_mug(const ShellGame& game, int env) const;
  void dense_reward(const ShellGame& game, Range envs, FloatRows out) const;

  // Whether mugs that were shoved by at most `displacement` m leave a success.
  static bool meets_extra_condition(double displacement);

 private:
  double goal_thresh_;  // m
  Form form_;
  Column<double> displacement_;  // m
  Column<float> mug_max_displacement_;
  Column<std::uint8_t> is_mug_displacement_ok_;
};

}  // namespace engram::tasks
