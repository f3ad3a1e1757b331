#include "core/contact/contact_filter.h"

#include <algorithm>

#include "core/robot/robot_params.h"

namespace engram {
namespace {

using Axes = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Vec3 = Eigen::Vector3d;

// Deeper than this, a contact of boxes is checked.
constexpr double kCredible = 0.001;  // m

// Nothing that moves gets so deep into an object.
constexpr double kEngulfed = 0.01;  // m
constexpr double kStuck = 0.0015;   // m, where neither a grip nor a hand from above pushes
constexpr double kSlanted = 0.7;    // cosine, between one direction and another

// How far a box reaches along a direction.
double half_extent(const mjModel& model, const mjData& data, int geom, const Vec3& direction) {
  const Eigen::Map<const Axes> axes(data.geom_xmat + 9 * geom);
  const Eigen::Map<const Vec3> half(model.geom_size + 3 * geom);
  return half.dot((axes.transpose() * direction).cwiseAbs());
}

// Near their corners MuJoCo finds contacts of boxes that are as deep as the boxes are large. No
// point can be deeper than the boxes overlap along the normal.
bool is_false(const mjModel& model, const mjData& data, const mjContact& contact) {
  const int first = contact.geom1;
  const int second = contact.geom2;
  if (contact.dist > -kCredible || model.geom_type[first] != mjGEOM_BOX ||
      model.geom_type[second] != mjGEOM_BOX) {
    return false;
  }
  const Eigen::Map<const Vec3> normal(contact.frame);
  const Eigen::Map<const Vec3> from(data.geom_xpos + 3 * first);
  const Eigen::Map<const Vec3> to(data.geom_xpos + 3 * second);
  const double apart = normal.dot(to - from) - half_extent(model, data, first, normal) -
                       half_extent(model, data, second, normal);
  return contact.dist < apart - kCredible;
}

// How fast a body's point moves at most, m/s. Of a kinematic body nothing is known here.
double fastest_at(const mjModel& model, const mjData& data, int body, const mjtNum* point) {
  if (model.body_mocapid[body] >= 0) return mjMAXVAL;
  if (!is_free_body(model, body)) return 0;
  const mjtNum* qvel = data.qvel + model.body_dofadr[body];
  const Vec3 lever = Eigen::Map<const Vec3>(point) - Eigen::Map<const Vec3>(data.xpos + 3 * body);
  return Eigen::Map<const Vec3>(qvel).norm() +
         Eigen::Map<const Vec3>(qvel + 3).norm() * lever.norm();
}

// Whether a contact may touch within this substep. Those of what rests may not, and cost nothing.
bool may_close(const mjModel& model, const mjData& data, const mjContact& contact) {
  constexpr double kSlack = 0.002;  // m, for what accelerates
  const double speed = fastest_at(model, data, model.geom_bodyid[contact.geom1], contact.pos) +
                       fastest_at(model, data, model.geom_bodyid[contact.geom2], contact.pos);
  return contact.dist < kSlack + model.opt.timestep * speed;
}

// A row's velocity v ends as v (1 - B I h) - K I^2 h r, with B = 2 / (I t), K = 1 / (I t)^2 and the
// time constant t, which is two substeps h. With this r, that is -dist / h: it closes the gap.
void foresee(mjContact& contact, double timestep) {
  const double ratio = contact.solref[0] / timestep;
  contact.exclude = 0;
  contact.dim = 1;
  contact.solimp[0] = contact.solimp[1];
  contact.includemargin = contact.dist - ratio * ratio * contact.dist;
}

bool is_robot(const mjModel& model, int body) {
  return body > 0 && model.body_mocapid[body] < 0 && !is_free_body(model, body);
}

// Of a contact between the robot and a free prop.
struct Meeting {
  int prop = -1;  // body; -1 if it is none
  int robot_geom = -1;
  double sign = 1;  // of the normal from the robot to the prop
};

Meeting meeting(const mjModel& model, const mjContact& contact) {
  const int first = model.geom_bodyid[contact.geom1];
  const int second = model.geom_bodyid[contact.geom2];
  if (is_robot(model, first) && is_free_body(model, second)) return {second, contact.geom1, 1};
  if (is_robot(model, second) && is_free_body(model, first)) return {first, contact.geom2, -1};
  return {};
}

// The depth from which a contact pushes out at kPace.
double depth_at_pace(const mjModel& model, const mjContact& contact) {
  constexpr double kPace = 0.1;  // m/s
  const double ratio = contact.solref[0] / model.opt.timestep;
  return ratio * ratio * model.opt.timestep * kPace;
}

// The closed fingers, where their tips are.
struct Tool {
  Vec3 middle = Vec3::Zero();
  Vec3 thin_side;
};

// A finger's tip is its last geom, and the fingers' joints are the robot's last.
Tool tool(const mjModel& model, const mjData& data) {
  Tool tool;
  for (int joint = kArmJoints; joint < kRobotJoints; ++joint) {
    const int finger = model.dof_bodyid[joint];
    const int tip = model.body_geomadr[finger] + model.body_geomnum[finger] - 1;
    tool.middle += Eigen::Map<const Vec3>(data.geom_xpos + 3 * tip) / kFingers;
    tool.thin_side = Eigen::Map<const Axes>(data.geom_xmat + 9 * tip).col(0);
  }
  return tool;
}

Vec3 level(const Vec3& v) { return {v.x(), v.y(), 0}; }

// From the tool to the prop, level; to the fingers' thin side if the prop is right around them.
Vec3 way_out(const mjModel& model, const mjData& data, int prop) {
  constexpr double kAround = 0.001;  // m
  const Tool fingers = tool(model, data);
  const Vec3 way = level(Eigen::Map<const Vec3>(data.xipos + 3 * prop) - fingers.middle);
  if (way.norm() > kAround) return way.normalized();
  const Vec3 thin = level(fingers.thin_side);
  return thin.norm() > mjMINVAL ? thin.normalized() : Vec3::UnitX().eval();
}

// Of a free body's point, or of one that the robot's joints move.
Vec3 velocity_at(const mjModel& model, const mjData& data, int body, const Vec3& point) {
  if (is_free_body(model, body)) {
    const mjtNum* qvel = data.qvel + model.body_dofadr[body];
    const Vec3 lever = point - Eigen::Map<const Vec3>(data.xpos + 3 * body);
    const Vec3 turning =
        Eigen::Map<const Axes>(data.xmat + 9 * body) * Eigen::Map<const Vec3>(qvel + 3);
    return Eigen::Map<const Vec3>(qvel) + turning.cross(lever);
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

// How deep a contact may be because of this substep's way.
double way_in(const mjModel& model, const mjData& data, const mjContact& contact) {
  const Eigen::Map<const Vec3> point(contact.pos);
  const Vec3 closing = velocity_at(model, data, model.geom_bodyid[contact.geom1], point) -
                       velocity_at(model, data, model.geom_bodyid[contact.geom2], point);
  return model.opt.timestep * closing.norm();
}

// Whether a contact may be that of a grip: of a finger's inner side, and something is between both.
bool may_grip(const mjModel& model, const mjData& data, const Meeting& here, const Vec3& normal) {
  constexpr double kClosed = 0.001;  // m
  const mjtNum* fingers = data.qpos + kArmJoints;
  if (fingers[0] + fingers[1] < kClosed) return false;
  const Vec3 inwards = level(tool(model, data).middle -
                             Eigen::Map<const Vec3>(data.geom_xpos + 3 * here.robot_geom));
  return normal.dot(inwards) > kSlanted * inwards.norm();
}

// Whether fingers are in the middle of a prop: deeper than anything gets that moves; or less deep,
// where the contact is neither that of a grip nor of a hand that comes from above.
bool is_engulfed(const mjModel& model, const mjData& data, const mjContact& contact,
                 const Meeting& here) {
  const double depth = -contact.dist - way_in(model, data, contact);
  if (depth > kEngulfed) return true;
  if (depth < kStuck) return false;
  const Vec3 normal = here.sign * Eigen::Map<const Vec3>(contact.frame);
  return normal.z() > -kSlanted && !may_grip(model, data, here, normal);
}

// An object that appears where the hand is has fingers in its middle. Their contacts would hold it
// from the inside. All that it has with the robot push it one way instead, slowly, level and
// without friction, until the fingers are nearly out.
void push_out(const mjModel& model, mjData& data, int prop) {
  const Vec3 way = way_out(model, data, prop);
  for (int i = 0; i < data.ncon; ++i) {
    mjContact& contact = data.contact[i];
    const Meeting here = meeting(model, contact);
    if (here.prop != prop) continue;
    contact.exclude = 0;
    contact.dim = 1;
    contact.solimp[0] = contact.solimp[1];
    contact.includemargin = contact.dist + depth_at_pace(model, contact);
    Eigen::Map<Vec3>(contact.frame) = here.sign * way;
  }
}

}  // namespace

void filter_contacts(const mjModel& model, mjData& data) {
  constexpr int kInGap = 1;  // as MuJoCo marks them
  constexpr int kFalse = 2;
  for (int i = 0; i < data.ncon; ++i) {
    mjContact& contact = data.contact[i];
    if (is_false(model, data, contact)) {
      contact.exclude = kFalse;
    } else if (contact.exclude == kInGap && may_close(model, data, contact)) {
      foresee(contact, model.opt.timestep);
    }
  }
  for (int i = 0; i < data.ncon; ++i) {
    mjContact& contact = data.contact[i];
    const double depth = depth_at_pace(model, contact);
    if (contact.dist > -std::min(kStuck, depth) || contact.dim == 1 || contact.exclude != 0)
      continue;
    const Meeting deep = meeting(model, contact);
    if (deep.prop < 0) continue;
    if (is_engulfed(model, data, contact, deep)) {
      push_out(model, data, deep.prop);
    } else if (contact.dist < -depth) {
      contact.includemargin = contact.dist + depth;  // nothing is thrown
    }
  }
}

}  // namespace engram
