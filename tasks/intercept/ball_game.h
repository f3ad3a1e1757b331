// Base of Intercept and InterceptGrab: a ball that rolls past the robot (docs/tasks/intercept.md).
#pragma once

#include <limits>
#include <optional>

#include "core/task/task.h"
#include "mjcf/prop.h"
#include "tasks/common/action_cost.h"
#include "tasks/common/constant_binder.h"
#include "tasks/common/family_base.h"
#include "tasks/common/random_variables.h"
#include "tasks/common/reward_dict.h"
#include "tasks/intercept/annotator.h"
#include "tasks/registry.h"

namespace engram::tasks {

inline constexpr double BALL_RADIUS = 0.02;  // m, unless a user changes it

// Parameters that both families have.
struct BallParams {
  SampledRange<double> VELOCITY_RANGE;      // m/s
  double BALL_RADIUS = tasks::BALL_RADIUS;  // m
  // In the original nothing comes of it. None: rewards know no action cost.
  std::optional<SmoothnessParams> smoothness = SmoothnessParams{};
  // Speed up to which the expert's hand runs along with the ball, m/s; it blocks faster ones.
  double fastest_followed = std::numeric_limits<double>::infinity();

  bool stops_first() const { return fastest_followed < std::numeric_limits<double>::infinity(); }
  // A ball that is not launched does not drift either.
  bool rests() const { return VELOCITY_RANGE.high == 0; }
  // Some balls may never come within reach.
  bool may_rest() const { return VELOCITY_RANGE.low == 0; }

  // On large and abrupt actions.
  double penalty(const Bindings& engine, int env) const {
    return smoothness ? smoothness_penalty(engine, env, *smoothness) : 0.0;
  }

  void declare(ConstantBinder& constants);
  // Throws Error unless even the slowest ball that is launched comes within reach in time.
  void check(int horizon) const;
};

// Random variables of a launch.
struct BallVariables {
  BallVariables(RandomVariables list, const BallParams& params);

  RealVariable ball_x;
  RealVariable ball_y;
  RealVariable velocity_x;
  RealVariable velocity_y;
};

// Parameters of both families' RL tasks. A hand whose joints turn by 0.1 rad at most runs along
// with slow balls alone.
constexpr BallParams rl_ball(double slowest, double fastest) {
  return {
      .VELOCITY_RANGE = {slowest, fastest}, .smoothness = std::nullopt, .fastest_followed = 0.34};
}

// Nothing is hidden at any time: there are no phases.
class BallGame : public FamilyBase {
 public:
  void bind(const Bindings& bindings) override;
  void reset(const Episode& episode) override;
  void advance(Range /*envs*/) override {}
  int cue_end(int /*env*/) const override { return 0; }
  void sampled_values(int env, float* out) const override { write_sampled_values(*this, env, out); }
  template <class Visitor>
  void sampled_row(Visitor& row, int env) const {
    row.field("initial_velocity", 3, "m/s", "of the ball", [&] { return initial_velocity(env); });
  }
  const Annotator* annotator() const override { return &annotator_; }

 protected:
  // `height`: of the ball's centre when it is let go, m.
  BallGame(const RegistryEntry& entry, const BallParams& ball, double height, InterceptGoal goal);

  // Shows the initial velocity as oracle_info.
  void publish_velocity(int env) const;

  Eigen::Vector3d ball(int env) const { return prop_pos(env, kBallProp); }
  Eigen::Vector3d linear_velocity(int env) const;   // m/s, world
  Eigen::Vector3d angular_velocity(int env) const;  // rad/s, world
  Eigen::Vector3d initial_velocity(int env) const;  // m/s

  // Fields of the state observation.
  template <class Visitor>
  void launch_fields(Visitor& row, int env) const {
    row.field("ball_pose", 7, "m", "position, quaternion (w, x, y, z)",
              [&] { return prop_pose(env, kBallProp); });
    row.field("oracle_info", 3, "m/s", "initial velocity of the ball",
              [&] { return initial_velocity(env); });
  }
  template <class Visitor>
  void motion_fields(Visitor& row, int env) const {
    row.field("ball_linear_vel", 3, "m/s", "", [&] { return linear_velocity(env); });
    row.field("ball_angular_vel", 3, "rad/s", "about the world's axes",
              [&] { return angular_velocity(env); });
    row.field("tcp_to_ball_pos", 3, "m", "",
              [&] { return Eigen::Vector3d(ball(env) - tcp_pos(env)); });
  }

  RewardDict reward_dict_;

 private:
  BallVariables variables_;
  double height_;
  Column<double> initial_velocity_;  // (3) m/s
  InterceptAnnotator annotator_;
};

}  // namespace engram::tasks
