// Numbers of the preset for training, and its options.
#pragma once

#include <array>
#include <numbers>

namespace engram::training {

// begin generated: numbers (tools/surface, from api/surface.toml)
// Shares of the largest motions that an action of 1 is: translation, rotation and gripper of
// pd_ee_delta_pose.
inline constexpr std::array<double, 7> kPoseScale = {0.3, 0.3, 0.3, 0.1, 0.1, 0.1, 0.5};
// The share of any component of another control mode.
inline constexpr double kOtherScale = 0.3;
// Unit of lengths in scaled observations, m.
inline constexpr double kLength = 0.1;
// Unit of angles, rad.
inline constexpr double kAngle = 0.5;
// Unit of speeds, m/s.
inline constexpr double kSpeed = 0.5;
// Unit of angular velocities, rad/s.
inline constexpr double kTurnRate = 1.0;
// Unit of a finger's opening, m.
inline constexpr double kFinger = 0.04;
// Largest scaled value.
inline constexpr double kLimit = 10.0;
// Rest pose of arm and fingers, rad and m.
inline constexpr std::array<double, 9> kRest = {
    0,    0,   0, -2 * std::numbers::pi / 3, 0, 2 * std::numbers::pi / 3, std::numbers::pi / 4,
    0.04, 0.04};
// Position of the TCP there, m.
inline constexpr std::array<double, 3> kRestTcp = {-0.0707, 0, 0.318};
// A coordinate of something hidden, m, and more.
inline constexpr double kHidden = 500.0;
// Distance from which on a distance counts in the potential, m: about that of the rest pose to the
// objects, so that the potential hardly jumps when they appear.
inline constexpr double kRange = 0.5;
// end generated

// A term of the task's reward in the potential. The names of terms that tell that a stage is over
// are empty where there is none.
struct TermRule {
  const char* name;
  double weight;
  const char* until;  // the term counts as reached once that one is 1
  const char* since;  // it counts nothing before that one is 1
};

// begin generated: terms
inline constexpr std::array<TermRule, 13> kTerms = {{
    {"tcp_to_obj_dist", 1.0, "", ""},
    {"tcp_to_hit_pose_dist", 1.0, "reached_status", ""},
    {"tcp_to_cube_dist", 1.0, "", ""},
    {"tcp_to_button_dist", 1.0, "", ""},
    {"tcp_push_dist", 1.0, "goal_reached_status", ""},
    {"tcp_pull_dist", 1.0, "", "goal_reached_status"},
    {"to_grip_dist", 1.0, "", ""},
    {"obj_to_goal_dist", 1.0, "", ""},
    {"place_in_goal_reward", 1.0, "goal_reached_status", ""},
    {"place_back_reward", 3.0, "", "goal_reached_status"},
    {"place_reward", 5.0, "", ""},
    {"keep_contact_reward", 1.0, "", "goal_reached_status"},
    {"y_angle_reward", 5.0, "", ""},
}};
inline constexpr const char* kStill = "static_reward";
inline constexpr std::array<const char*, 3> kThere = {"reached", "is_obj_placed",
                                                      R"(info["is_obj_placed"])"};
// end generated

struct Options {
  // begin generated: options
  // Discount of the learner; more than 0, up to 1.
  double gamma = 0.99;
  // An action of 1 is 0.3 of the arm's largest motion, 0.1 of its largest rotation, 0.5 of the
  // gripper's; larger ones reach the limits.
  bool scale_actions = true;
  // Weight of an episode's past actions in the next one; 0 (none) to less than 1.
  double smoothing = 0.0;
  // Rows of states in fixed units from the TCP, rows of objects in a lasting order too.
  bool scale_observations = true;
  // One more column where there are rows: the share of the horizon that is left.
  bool time_left = true;
  // Weight of the dense reward in the potential whose differences are the reward, 0 or more; 0: no
  // potential, the reward is the batch's own.
  double potential = 1.0;
  // Weight of standing still in the potential, where the arm has to, 0 (none) or more.
  double still = 0.0;
  // For each step that the first success leaves of the horizon, discounted, 0 (none) or more.
  double bonus = 0.1;
  // end generated
};

}  // namespace engram::training
