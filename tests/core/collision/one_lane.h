// The broad phase of one environment.
#pragma once

#include "core/collision/pair_search.h"
#include "core/contact/contact_kernel.h"
#include "core/robot/lane_block.h"
#include "core/scene/physics_model.h"

namespace engram::test {

class OneLane {
 public:
  explicit OneLane(const PhysicsModel& model)
      : robot_(model.robot_model()),
        robots_(*lane_kernel(1)),
        broad_phase_(model.collision(), model.robot_params().timestep, 1),
        scene_(model.collision()) {}

  BroadPhase& broad_phase() { return broad_phase_; }
  LaneBlock& robots() { return robots_; }

  void place_robot(const double* qpos, const JointArray& qvel = {}) {
    robots_.put(LaneVectors::kQ, 0, qpos, kRobotJoints);
    robots_.put(LaneVectors::kV, 0, qvel.data(), kRobotJoints);
    robots_.kernel().pose_links(robot_, robots_.vectors());
    contact_kernel(1).pose_robot(robot_, robots_.vectors(), broad_phase_.view());
  }

  const BroadPhase& find(const BodyStates& bodies) {
    broad_phase_.clear();
    for (std::size_t i = 0; i < scene_.bodies().size(); ++i) {
      if (scene_.bodies()[i].prop < 0) continue;
      broad_phase_.put(0, static_cast<int>(i), bodies.frames[i], bodies.speeds[i]);
    }
    broad_phase_.enter(0, bodies.presence);
    contact_kernel(1).find_near(broad_phase_.view());
    return broad_phase_;
  }

 private:
  const RobotModel& robot_;
  LaneBlock robots_;
  BroadPhase broad_phase_;
  const CollisionScene& scene_;
};

}  // namespace engram::test
