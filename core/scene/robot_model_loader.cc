#include "core/scene/robot_model_loader.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/index.h"
#include "core/math/frame.h"
#include "core/robot/arm.h"

namespace engram {
namespace {

void require(bool holds, const char* what) {
  if (!holds) throw Error(Error::kInternal, std::string("the robot's kernels need ") + what);
}

Quat quat_of(const mjtNum* q) { return {q[0], q[1], q[2], q[3]}; }

// Frame of a body in that of one of its ancestors; 0: of the world.
Frame frame_in(const mjModel& model, int body, int ancestor) {
  Frame frame;
  for (; body != ancestor; body = model.body_parentid[body]) {
    require(body > 0, "links that carry one another");
    const Mat3 axes = quat_of(model.body_quat + 4 * body).toRotationMatrix();
    frame.pos = Vec3(Eigen::Map<const Vec3>(model.body_pos + 3 * body) + axes * frame.pos);
    frame.axes = axes * frame.axes;
  }
  return frame;
}

// The nearest ancestor with a joint, itself included; or the world.
int moving_body(const mjModel& model, int body) {
  while (body > 0 && model.body_jntnum[body] == 0) body = model.body_parentid[body];
  return body;
}

// Sums over bodies that are fixed to one another, in the frame of one of them.
struct Composite {
  double mass = 0;
  Vec3 moment = Vec3::Zero();   // mass times centre
  Mat3 inertia = Mat3::Zero();  // about the frame's origin

  void add(double body_mass, const Vec3& center, const Mat3& about_center) {
    mass += body_mass;
    moment += body_mass * center;
    inertia += about_center +
               body_mass * (center.squaredNorm() * Mat3::Identity() - center * center.transpose());
  }
};

void set_link(const Composite& composite, const Frame& frame, RobotModel::Link& link) {
  const Vec3 center = composite.mass > 0 ? Vec3(composite.moment / composite.mass) : Vec3::Zero();
  const Mat3 inertia =
      composite.inertia -
      composite.mass * (center.squaredNorm() * Mat3::Identity() - center * center.transpose());
  link.mass = composite.mass;
  Eigen::Map<Vec3>(link.offset) = frame.pos;
  Eigen::Map<RowMat3>(link.rotation) = frame.axes;
  Eigen::Map<Vec3>(link.center) = center;
  const double values[6] = {inertia(0, 0), inertia(1, 1), inertia(2, 2),
                            inertia(0, 1), inertia(0, 2), inertia(1, 2)};
  std::copy_n(values, 6, link.inertia);
}

// Everything that `link` carries without a joint between, in its frame rotated by `axes`.
Composite composite_of(const mjModel& model, int link, const Mat3& axes, int last_body) {
  Composite composite;
  for (int body = 1; body <= last_body; ++body) {
    if (moving_body(model, body) != link) continue;
    const Frame frame = frame_in(model, body, link);
    const Mat3 own = axes * frame.axes * quat_of(model.body_iquat + 4 * body).toRotationMatrix();
    const Vec3 center =
        axes * (frame.pos + frame.axes * Eigen::Map<const Vec3>(model.body_ipos + 3 * body));
    const Eigen::Map<const Vec3> principal(model.body_inertia + 3 * body);
    composite.add(model.body_mass[body], center, own * principal.asDiagonal() * own.transpose());
  }
  return composite;
}

int last_robot_body(const mjModel& model) {
  int last = model.jnt_bodyid[kRobotJoints - 1];
  for (int body = last + 1; body < model.nbody; ++body) {
    if (moving_body(model, body) == last) last = body;
  }
  return last;
}

void set_quat(const Quat& quat, double* to) {
  const double values[4] = {quat.w(), quat.x(), quat.y(), quat.z()};
  std::copy_n(values, 4, to);
}

// Rotation of the fixed bodies between two joints.
Quat rotation_between(const mjModel& model, int body, int ancestor) {
  Quat rotation = Quat::Identity();
  for (; body != ancestor; body = model.body_parentid[body]) {
    rotation = quat_of(model.body_quat + 4 * body) * rotation;
  }
  return rotation;
}

void read_arm(const mjModel& model, int last_body, RobotModel& robot) {
  for (int joint = 0; joint < kArmJoints; ++joint) {
    const int body = model.jnt_bodyid[joint];
    const Eigen::Map<const Vec3> axis(model.jnt_axis + 3 * joint);
    const Eigen::Map<const Vec3> anchor(model.jnt_pos + 3 * joint);
    require(model.jnt_type[joint] == mjJNT_HINGE && axis == Vec3::UnitZ() && anchor.isZero(0) &&
                model.body_jntnum[body] == 1,
            "seven hinges about their bodies' z axes");
    const int ancestor = joint == 0 ? 0 : model.jnt_bodyid[joint - 1];
    require(moving_body(model, model.body_parentid[body]) == ancestor, "seven hinges in a row");
    Frame frame = frame_in(model, body, ancestor);
    if (joint == 0) frame.pos -= Eigen::Map<const Vec3>(robot.base_position);
    const auto index = at(joint);
    set_link(composite_of(model, body, Mat3::Identity(), last_body), frame, robot.links[index]);
    set_quat(rotation_between(model, body, ancestor), robot.link_quat[index]);
  }
}

void read_fingers(const mjModel& model, int last_body, RobotModel& robot) {
  const int last_link = model.jnt_bodyid[kArmJoints - 1];
  for (int finger = 0; finger < kFingers; ++finger) {
    const int joint = kArmJoints + finger;
    const int body = model.jnt_bodyid[joint];
    require(model.jnt_type[joint] == mjJNT_SLIDE && model.body_jntnum[body] == 1 &&
                moving_body(model, model.body_parentid[body]) == last_link,
            "two fingers that slide on the last link");
    const Frame frame = frame_in(model, body, last_link);
    const auto index = at(finger);
    set_link(composite_of(model, body, frame.axes, last_body), frame, robot.fingers[index]);
    Eigen::Map<Vec3>(robot.finger_axis[index]) =
        frame.axes * Eigen::Map<const Vec3>(model.jnt_axis + 3 * joint);
  }
}

// Centres of mass of the rigid bodies by themselves.
void read_centers(const mjModel& model, RobotModel& robot) {
  const auto set = [&](int link, int body) {
    const int carrier = model.jnt_bodyid[hinges_of(link) - 1];
    const Frame frame = frame_in(model, body, carrier);
    Eigen::Map<Vec3>(robot.centers[link]) =
        frame.pos + frame.axes * Eigen::Map<const Vec3>(model.body_ipos + 3 * body);
  };
  for (int joint = 0; joint < kRobotJoints; ++joint) set(joint, model.jnt_bodyid[joint]);
  const std::pair<int, const char*> fixed[] = {{kHandLink, "hand"}, {kCameraLink, "camera_link"}};
  for (const auto& [link, name] : fixed) {
    const int body = mj_name2id(&model, mjOBJ_BODY, name);
    require(body >= 0, "a hand and a camera");
    set(link, body);
  }
}

}  // namespace

RobotModel load_robot_model(const mjModel& model) {
  require(model.njnt >= kRobotJoints, "seven hinges and two fingers");
  RobotModel robot;
  const int first = model.jnt_bodyid[0];
  require(model.body_parentid[first] > 0, "a base");
  std::copy_n(model.body_pos + 3 * model.body_rootid[first], 3, robot.base_position);
  const int last_body = last_robot_body(model);
  read_arm(model, last_body, robot);
  read_fingers(model, last_body, robot);
  read_centers(model, robot);

  const int site = mj_name2id(&model, mjOBJ_SITE, "tcp");
  require(site >= 0, "a site named 'tcp'");
  const int last_link = model.jnt_bodyid[kArmJoints - 1];
  const int body = model.site_bodyid[site];
  require(moving_body(model, body) == last_link, "a TCP on the last link");
  const Frame frame = frame_in(model, body, last_link);
  Eigen::Map<Vec3>(robot.tcp_offset) =
      frame.pos + frame.axes * Eigen::Map<const Vec3>(model.site_pos + 3 * site);
  set_quat(rotation_between(model, body, last_link) * quat_of(model.site_quat + 4 * site),
           robot.tcp_quat);
  robot.single = rounded<RobotModelOf>(robot);
  return robot;
}

// Here, so that code which is given an arm needs nothing of MuJoCo (docs/cpp_tasks.md).
Arm::Arm(const mjModel& model)
    : model_(load_robot_model(model)),
      base_position_(Eigen::Map<const Vec3>(model_.base_position)) {}

}  // namespace engram
