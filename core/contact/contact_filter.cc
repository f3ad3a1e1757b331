#include "core/contact/contact_filter.h"

#include <algorithm>

#include "core/math/eigen_types.h"
#include "core/robot/robot_params.h"

namespace engram {
namespace {

using Axes = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// Contacts of boxes are checked from this depth on.
constexpr double kMaxFalseDepth = 0.001;  // m

// Penetration depths from which the robot and a prop are pushed apart: in any contact, and in one
// that belongs neither to a grip nor to a hand that presses from above.
constexpr double kDeepPenetration = 0.01;       // m
constexpr double kShallowPenetration = 0.0015;  // m
constexpr double kAlignedCosine = 0.7;          // between directions that count as aligned

// Half extent of a box along a direction (its support function).
double half_extent(const mjModel& model, const mjData& data, int geom, const Vec3& direction) {
  const Eigen::Map<const Axes> axes(data.geom_xmat + 9 * geom);
  const Eigen::Map<const Vec3> half(model.geom_size + 3 * geom);
  return half.dot((axes.transpose() * direction).cwiseAbs());
}

// Detects false contacts: near corners MuJoCo finds contacts of boxes as deep as the boxes. No
// point can be deeper than the boxes overlap along the normal.
bool is_false_contact(const mjModel& model, const mjData& data, const mjContact& contact) {
  const int first = contact.geom1;
  const int second = contact.geom2;
  if (contact.dist > -kMaxFalseDepth || model.geom_type[first] != mjGEOM_BOX ||
      model.geom_type[second] != mjGEOM_BOX) {
    return false;
  }
  const Eigen::Map<const Vec3> normal(contact.frame);
  const Eigen::Map<const Vec3> from(data.geom_xpos + 3 * first);
  const Eigen::Map<const Vec3> to(data.geom_xpos + 3 * second);
  const double apart = normal.dot(to - from) - half_extent(model, data, first, normal) -
                       half_extent(model, data, second, normal);
  return contact.dist < apart - kMaxFalseDepth;
}

// Upper bound of the speed of a body's point, m/s. The velocity of kinematic bodies is unknown.
double max_speed_at(const mjModel& model, const mjData& data, int body, const mjtNum* point) {
  if (model.body_mocapid[body] >= 0) return mjMAXVAL;
  if (!is_free_body(model, body)) return 0;
  const mjtNum* qvel = data.qvel + model.body_dofadr[body];
  const Vec3 lever = Eigen::Map<const Vec3>(point) - Eigen::Map<const Vec3>(data.xpos + 3 * body);
  return Eigen::Map<const Vec3>(qvel).norm() +
         Eigen::Map<const Vec3>(qvel + 3).norm() * lever.norm();
}

// Tests for a contact that may touch within this substep. Contacts of resting bodies may not, and
// cost nothing.
bool may_touch_within_substep(const mjModel& model, const mjData& data, const mjContact& contact) {
  constexpr double kSlack = 0.002;  // m, for what accelerates
  const double speed = max_speed_at(model, data, model.geom_bodyid[contact.geom1], contact.pos) +
                       max_speed_at(model, data, model.geom_bodyid[contact.geom2], contact.pos);
  return contact.dist < kSlack + model.opt.timestep * speed;
}

// Speculative contact: lets the bodies approach no farther than to touch at the end of the substep.
// A row's velocity v becomes v (1 - B I h) - K I^2 h r, with B = 2 / (I t), K = 1 / (I t)^2 and the
// time constant t, which is two substeps h. With this r, that is -dist / h, which closes the gap.
void make_speculative(mjContact& contact, double timestep) {
  const double ratio = contact.solref[0] / timestep;
  contact.exclude = 0;
  contact.dim = 1;
  contact.solimp[0] = contact.solimp[1];
  contact.includemargin = contact.dist - ratio * ratio * contact.dist;
}

bool is_robot(const mjModel& model, int body) {
  return body > 0 && model.body_mocapid[body] < 0 && !is_free_body(model, body);
}

// A contact between the robot and a free prop.
struct RobotPropContact {
  int prop = -1;  // body; -1 if it is none
  int robot_geom = -1;
  double sign = 1;  // of the normal from the robot to the prop
};

RobotPropContact robot_prop_contact(const mjModel& model, const mjContact& contact) {
  const int first = model.geom_bodyid[contact.geom1];
  const int second = model.geom_bodyid[contact.geom2];
  if (is_robot(model, first) && is_free_body(model, second)) return {second, contact.geom1, 1};
  if (is_robot(model, second) && is_free_body(model, first)) return {first, contact.geom2, -1};
  return {};
}

// Depth at which a contact separates at kDepenetrationSpeed.
double depth_at_speed(const mjModel& model, const mjContact& contact) {
  constexpr double kDepenetrationSpeed = 0.1;  // m/s
  const double ratio = contact.solref[0] / model.opt.timestep;
  return ratio * ratio * model.opt.timestep * kDepenetrationSpeed;
}

// Pose of the closed finger tips.
struct FingerTips {
  Vec3 middle = Vec3::Zero();
  Vec3 thin_side;
};

// Reads it from data: a finger's tip is its last geom, and the fingers' joints are the robot's
// last.
FingerTips finger_tips(const mjModel& model, const mjData& data) {
  FingerTips tips;
  for (int joint = kArmJoints; joint < kRobotJoints; ++joint) {
    const int finger = model.dof_bodyid[joint];
    const int tip = model.body_geomadr[finger] + model.body_geomnum[finger] - 1;
    tips.middle += Eigen::Map<const Vec3>(data.geom_xpos + 3 * tip) / kFingers;
    tips.thin_side = Eigen::Map<const Axes>(data.geom_xmat + 9 * tip).col(0);
  }
  return tips;
}

Vec3 horizontal(const Vec3& v) { return {v.x(), v.y(), 0}; }

// Horizontal direction from the finger tips to the prop; to the fingers' thin side if the prop is
// centred on them.
Vec3 depenetration_direction(const mjModel& model, const mjData& data, int prop) {
  constexpr double kCentered = 0.001;  // m
  const FingerTips fingers = finger_tips(model, data);
  const Vec3 direction = horizontal(Eigen::Map<const Vec3>(data.xipos + 3 * prop) - fingers.middle);
  if (direction.norm() > kCentered) return direction.normalized();
  const Vec3 thin = horizontal(fingers.thin_side);
  return thin.norm() > mjMINVAL ? thin.normalized() : Vec3::UnitX().eval();
}

// Velocity of a point of a free body, or of a body that the robot's joints move.
Vec3 velocity_at(const mjModel& model, const mjData& data, int body, const Vec3& point) {
  if (is_free_body(model, body)) {
    const mjtNum* qvel = data.qvel + model.body_dofadr[body];
    const Vec3 lever = point - Eigen::Map<const Vec3>(data.xpos + 3 * body);
    const Vec3 spin =
        Eigen::Map<const Axes>(data.xmat + 9 * body) * Eigen::Map<const Vec3>(qvel + 3);
    return Eigen::Map<const Vec3>(qvel) + spin.cross(lever);
  }
  while (body > 0 && model.body_dofnum[body] == 0) body = model.body_parentid[body];
  Vec3 velocity = Vec3::Zero();
  int joint = body > 0 ? model.body_dofadr[body] : -1;
  for (; joint >= 0; joint = model.dof_parentid[joint]) {
    const Eigen::Map<const Vec3> axis(data.xaxis + 3 * joint);
    const Vec3 lever = point - Eigen::Map<const Vec3>(data.xanchor + 3 * joint);
    const bool turns = model.jnt_type[joint] == mjJNT_HINGE;
    velocity += data.qvel[joint] * (turns ? axis.cross(lever) : Vec3(axis));
  }
  return velocity;
}

// Depth that a contact may have from the approach within this substep.
double approach_distance(const mjModel& model, const mjData& data, const mjContact& contact) {
  const Eigen::Map<const Vec3> point(contact.pos);
  const Vec3 closing = velocity_at(model, data, model.geom_bodyid[contact.geom1], point) -
                       velocity_at(model, data, model.geom_bodyid[contact.geom2], point);
  return model.opt.timestep * closing.norm();
}

// Tests for a possible grip contact: on a finger's inner side, with something between the fingers.
bool may_grip(const mjModel& model, const mjData& data, const RobotPropContact& pair,
              const Vec3& normal) {
  constexpr double kClosed = 0.001;  // m
  const mjtNum* fingers = data.qpos + kArmJoints;
  if (fingers[0] + fingers[1] < kClosed) return false;
  const Vec3 inwards = horizontal(finger_tips(model, data).middle -
                                  Eigen::Map<const Vec3>(data.geom_xpos + 3 * pair.robot_geom));
  return normal.dot(inwards) > kAlignedCosine * inwards.norm();
}

// Tests for fingers inside a prop: deeper than motion gets them; or less deep, if the contact is
// neither that of a grip nor of a hand that presses from above.
bool is_deeply_penetrating(const mjModel& model, const mjData& data, const mjContact& contact,
                           const RobotPropContact& pair) {
  const double depth = -contact.dist - approach_distance(model, data, contact);
  if (depth > kDeepPenetration) return true;
  if (depth < kShallowPenetration) return false;
  const Vec3 normal = pair.sign * Eigen::Map<const Vec3>(contact.frame);
  return normal.z() > -kAlignedCosine && !may_grip(model, data, pair, normal);
}

// Depenetration: an object that appears around the fingers would be held from the inside. All its
// contacts with the robot push it in one horizontal direction instead, slowly and without friction,
// until the fingers are nearly out.
void depenetrate(const mjModel& model, mjData& data, int prop) {
  const Vec3 direction = depenetration_direction(model, data, prop);
  for (int i = 0; i < data.ncon; ++i) {
    mjContact& contact = data.contact[i];
    const RobotPropContact pair = robot_prop_contact(model, contact);
    if (pair.prop != prop) continue;
    contact.exclude = 0;
    contact.dim = 1;
    contact.solimp[0] = contact.solimp[1];
    contact.includemargin = contact.dist + depth_at_speed(model, contact);
    Eigen::Map<Vec3>(contact.frame) = pair.sign * direction;
  }
}

}  // namespace

void filter_contacts(const mjModel& model, mjData& data) {
  constexpr int kInGap = 1;  // as MuJoCo marks them
  constexpr int kFalse = 2;
  for (int i = 0; i < data.ncon; ++i) {
    mjContact& contact = data.contact[i];
    if (is_false_contact(model, data, contact)) {
      contact.exclude = kFalse;
    } else if (contact.exclude == kInGap && may_touch_within_substep(model, data, contact)) {
      make_speculative(contact, model.opt.timestep);
    }
  }
  for (int i = 0; i < data.ncon; ++i) {
    mjContact& contact = data.contact[i];
    const double depth = depth_at_speed(model, contact);
    if (contact.dist > -std::min(kShallowPenetration, depth) || contact.dim == 1 ||
        contact.exclude != 0)
      continue;
    const RobotPropContact pair = robot_prop_contact(model, contact);
    if (pair.prop < 0) continue;
    if (is_deeply_penetrating(model, data, contact, pair)) {
      depenetrate(model, data, pair.prop);
    } else if (contact.dist < -depth) {
      contact.includemargin = contact.dist + depth;  // nothing is thrown
    }
  }
}

}  // namespace engram
