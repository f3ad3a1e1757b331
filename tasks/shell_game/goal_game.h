// Base of the shell games with a goal: the mug that hides the ball, or the ball itself, has to come
// into a region.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "tasks/shell_game/annotator.h"
#include "tasks/shell_game/game.h"

namespace engram::tasks {

class GoalGame : public ShellGame {
 public:
  void bind(const Bindings& bindings) override;
  void advance(Range envs) override;
  void evaluate(Range envs) override;
  void observe(Range envs, FloatRows out) override { write_state(*this, envs, out); }
  template <class Visitor>
  void state_row(Visitor& row, int env) const {
    row.field("goal_pos", 3, "m", "centre of the goal region", [&] { return goal_pos(env); });
    row.field("obj_pose", 7, "m", "of the mug over the ball",
              [&] { return prop_pose(env, target_[env]); });
    if (form_.handle) {
      row.field("handle_pos", 3, "m", "nominal grip of that mug", [&] { return handle_pos(env); });
    }
    row.field("ball_pose", 7, "m", "of the red ball", [&] { return prop_pose(env, ball_); });
    row.field("oracle_info", 1, "", "slot of the ball", [&] { return target_[env]; });
    if (lifts()) {
      row.field("is_grasped", 1, "", "of that mug", [&] { return is_grasped_[env]; });
    }
  }
  const Annotator* annotator() const override { return &annotator_; }

 protected:
  struct Form {
    ShellGameAnnotator::Skill skill;
    Eigen::Vector3d from_ball;  // the region's centre, from the ball in its slot, m
    double static_speed = 0.2;  // rad/s, of a robot that stands still
    std::optional<Eigen::Vector3d> handle = {};  // from the mug's origin, m; shown in the state
  };
  GoalGame(const RegistryEntry& entry, const ShellGameParams& params, const Setup& setup,
           const Form& form);

  // To be called by bind(). A mug that is moved farther than `answer_distance`, m, is the robot's
  // answer.
  void set_item(GoalItem item, double answer_distance);

  Eigen::Vector3d mug_pos(int env) const { return mugs_.pos(env, target_[env]); }
  Eigen::Vector3d handle_pos(int env) const { return mug_pos(env) + *form_.handle; }
  bool is_grasped(int env) const { return is_grasped_[env] != 0; }

 private:
  bool lifts() const { return form_.skill == ShellGameAnnotator::Skill::kPick; }
  Eigen::Vector3d ball_slot(int env) const {
    return mugs_.slot_pos(env, target_[env], params().BALL_RADIUS);
  }
  Eigen::Vector3d goal_pos(int env) const { return ball_slot(env) + form_.from_ball; }
  bool is_ball_moved(int env) const;

  Form form_;
  GoalItem item_ = GoalItem::kMug;
  double answer_distance_ = 0;  // m
  int ball_;
  int goal_;
  Column<std::uint8_t> is_grasped_;
  ShellGameAnnotator annotator_;
};

}  // namespace engram::tasks
