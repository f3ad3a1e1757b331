// Control modes: the meanings of actions, and their names.
#pragma once

#include <array>

#include "core/base/names.h"

namespace engram {

// begin generated: enum (tools/surface, from api/surface.toml)
// Meaning of actions; in brackets their dimension.
enum class ControlMode {
  kPdJointDeltaPos,        // (8)
  kPdJointPos,             // (8) not normalised
  kPdEeDeltaPos,           // (4)
  kPdEeDeltaPose,          // (7) canonical
  kPdEePose,               // (7) unbounded, not normalised
  kPdJointTargetDeltaPos,  // (8)
  kPdEeTargetDeltaPos,     // (4)
  kPdEeTargetDeltaPose,    // (7)
  kPdJointVel,             // (8)
  kPdJointPosVel,          // (15) not normalised
  kPdJointDeltaPosVel,     // (15)
};
inline constexpr std::array kControlModeNames = {
    "pd_joint_delta_pos",
    "pd_joint_pos",
    "pd_ee_delta_pos",
    "pd_ee_delta_pose",
    "pd_ee_pose",
    "pd_joint_target_delta_pos",
    "pd_ee_target_delta_pos",
    "pd_ee_target_delta_pose",
    "pd_joint_vel",
    "pd_joint_pos_vel",
    "pd_joint_delta_pos_vel",
};
constexpr const auto& names_of(ControlMode) { return kControlModeNames; }
// end generated

inline constexpr int kControlModes = static_cast<int>(kControlModeNames.size());

}  // namespace engram
