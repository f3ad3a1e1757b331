#include "core/scene/scene_kinematics.h"

#include "core/scene/free_body.h"

namespace engram {
namespace {

using RowMat3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Vec3d = Eigen::Vector3d;

void set_frame(const Frame& frame, mjtNum* pos, mjtNum* axes) {
  Eigen::Map<Vec3d> at(pos);
  Eigen::Map<RowMat3> turned(axes);
  at = frame.pos;
  turned = frame.axes;
}

Frame within(const Frame& outer, const Frame& inner) {
  return {outer.pos + outer.axes * inner.pos, outer.axes * inner.axes};
}

}  // namespace

SceneKinematics::SceneKinematics(const mjModel& model)
    : model_(&model), geoms_(static_cast<std::size_t>(model.nbody)) {
  for (int body = 1; body < model.nbody; ++body) {
    if (model.body_mocapid[body] >= 0 || is_free_body(model, body)) {
      props_.push_back(body);
      continue;
    }
    const Attachment attachment = attachment_of(model, body);
    if (attachment.link < 0) continue;
    robot_.push_back(
        {body, attachment, make_frame(model.body_ipos + 3 * body, model.body_iquat + 4 * body)});
  }
  for (int geom = 0; geom < model.ngeom; ++geom) {
    geoms_[static_cast<std::size_t>(model.geom_bodyid[geom])].push_back(
        {geom, make_frame(model.geom_pos + 3 * geom, model.geom_quat + 4 * geom)});
  }
}

void SceneKinematics::pose_fixed(mjData& data) const { mj_kinematics(model_, &data); }

void SceneKinematics::pose(const RobotPose& robot, mjData& data) const {
  pose_robot(robot, data);
  for (const int body : props_) pose_prop(body, data);
}

void SceneKinematics::pose_robot(const RobotPose& robot, mjData& data) const {
  for (const RobotBody& part : robot_) {
    const Frame frame = carried(robot, part.attachment);
    set_body(part.body, frame, data);
    set_frame(within(frame, part.center), data.xipos + 3 * part.body, data.ximat + 9 * part.body);
  }
  for (int joint = 0; joint < kRobotJoints; ++joint) {
    const Frame& link = robot.links[static_cast<std::size_t>(joint)];
    Eigen::Map<Vec3d>(data.xanchor + 3 * joint) = link.pos;
    Eigen::Map<Vec3d>(data.xaxis + 3 * joint) =
        link.axes * Eigen::Map<const Vec3d>(model_->jnt_axis + 3 * joint);
  }
}

void SceneKinematics::pose_prop(int body, mjData& data) const {
  const int mocap = model_->body_mocapid[body];
  const mjtNum* pos = nullptr;
  mjtNum quat[4];
  if (mocap >= 0) {
    pos = data.mocap_pos + 3 * mocap;
    mju_copy4(quat, data.mocap_quat + 4 * mocap);
  } else {
    pos = data.qpos + model_->jnt_qposadr[model_->body_jntadr[body]];
    mju_copy4(quat, pos + 3);
  }
  mju_normalize4(quat);
  mju_copy4(data.xquat + 4 * body, quat);
  const Frame frame = make_frame(pos, quat);
  set_body(body, frame, data);
  const Frame center = make_frame(model_->body_ipos + 3 * body, model_->body_iquat + 4 * body);
  set_frame(within(frame, center), data.xipos + 3 * body, data.ximat + 9 * body);
}

void SceneKinematics::set_body(int body, const Frame& frame, mjData& data) const {
  set_frame(frame, data.xpos + 3 * body, data.xmat + 9 * body);
  for (const Geom& geom : geoms_[static_cast<std::size_t>(body)]) {
    set_frame(within(frame, geom.frame), data.geom_xpos + 3 * geom.geom,
              data.geom_xmat + 9 * geom.geom);
  }
}

}  // namespace engram
