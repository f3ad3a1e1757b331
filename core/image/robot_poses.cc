#include "core/image/robot_poses.h"

#include "core/base/error.h"
#include "core/math/rotations.h"

namespace engram {

RobotPoses::RobotPoses(const mjModel& robot) {
  for (int body = 1; body < robot.nbody; ++body) {
    Body entry;
    entry.parent = robot.body_parentid[body] - 1;
    entry.pos = Eigen::Map<const Eigen::Vector3d>(robot.body_pos + 3 * body);
    const mjtNum* q = robot.body_quat + 4 * body;
    entry.quat = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
    entry.axis.setZero();
    if (robot.body_jntnum[body] > 0) {
      const int joint = robot.body_jntadr[body];
      const int type = robot.jnt_type[joint];
      if (robot.body_jntnum[body] > 1 || (type != mjJNT_HINGE && type != mjJNT_SLIDE)) {
        throw Error(Error::kInternal, "robot body with other joints than one hinge or slide");
      }
      entry.qpos = robot.jnt_qposadr[joint];
      entry.slides = type == mjJNT_SLIDE;
      entry.axis = Eigen::Map<const Eigen::Vector3d>(robot.jnt_axis + 3 * joint);
    }
    names_.emplace_back(mj_id2name(&robot, mjOBJ_BODY, body));
    bodies_.push_back(entry);
  }
}

void RobotPoses::compute(const double* qpos, std::span<BodyView> out) const {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    Eigen::Vector3d pos = body.pos;
    Eigen::Quaterniond quat = body.quat;
    if (body.qpos >= 0 && body.slides) pos += quat * (body.axis * qpos[body.qpos]);
    if (body.qpos >= 0 && !body.slides) {
      quat = quat * turn_about(body.axis, qpos[body.qpos]);
    }
    if (body.parent >= 0) {
      const BodyView& parent = out[static_cast<std::size_t>(body.parent)];
      const Eigen::Quaterniond around(parent.quat[0], parent.quat[1], parent.quat[2],
                                      parent.quat[3]);
      pos = Eigen::Map<const Eigen::Vector3d>(parent.pos) + around * pos;
      quat = around * quat;
    }
    Eigen::Map<Eigen::Vector3d>(out[i].pos) = pos;
    out[i].quat[0] = quat.w();
    out[i].quat[1] = quat.x();
    out[i].quat[2] = quat.y();
    out[i].quat[3] = quat.z();
  }
}

}  // namespace engram
