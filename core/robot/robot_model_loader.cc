#include "core/robot/robot_model_loader.h"

#include <Eigen/Dense>
#include <algorithm>
#include <string>

#include "core/base/error.h"

namespace engram {
namespace {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using RowMat3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

void require(bool holds, const char* what) {
  if (!holds) throw Error(Error::kInternal, std::string("the robot's kernels need ") + what);
}

Eigen::Quaterniond quat_at(const mjtNum* q) { return {q[0], q[1], q[2], q[3]}; }

struct Place {
  Vec3 pos = Vec3::Zero();
  Mat3 axes = Mat3::Identity();
};

// Of a body in the frame of one that carries it; of the world if that is 0.
Place place_in(const mjModel& model, int body, int carrier) {
  Place place;
  for (; body != carrier; body = model.body_parentid[body]) {
    require(body > 0, "links that carry one another");
    const Mat3 axes = quat_at(model.body_quat + 4 * body).toRotationMatrix();
    place.pos = Vec3(Eigen::Map<const Vec3>(model.body_pos + 3 * body) + axes * place.pos);
    place.axes = axes * place.axes;
  }
  return place;
}

// The nearest body with a joint that carries this one, itself included; or the world.
int moving_body(const mjModel& model, int body) {
  while (body > 0 && model.body_jntnum[body] == 0) body = model.body_parentid[body];
  return body;
}

// Sums of bodies that are fixed to one another, in the frame of one of them.
struct Lump {
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

void set_link(const Lump& lump, const Place& place, RobotModel::Link& link) {
  const Vec3 center = lump.mass > 0 ? Vec3(lump.moment / lump.mass) : Vec3::Zero();
  const Mat3 inertia = lump.inertia - lump.mass * (center.squaredNorm() * Mat3::Identity() -
                                                   center * center.transpose());
  link.mass = lump.mass;
  Eigen::Map<Vec3>(link.offset) = place.pos;
  Eigen::Map<RowMat3>(link.turn) = place.axes;
  Eigen::Map<Vec3>(link.center) = center;
  const double values[6] = {inertia(0, 0), inertia(1, 1), inertia(2, 2),
                            inertia(0, 1), inertia(0, 2), inertia(1, 2)};
  std::copy_n(values, 6, link.inertia);
}

// Everything that `link` carries without a joint between, in its frame turned by `axes`.
Lump lump_of(const mjModel& model, int link, const Mat3& axes, int last_body) {
  Lump lump;
  for (int body = 1; body <= last_body; ++body) {
    if (moving_body(model, body) != link) continue;
    const Place place = place_in(model, body, link);
    const Mat3 own = axes * place.axes * quat_at(model.body_iquat + 4 * body).toRotationMatrix();
    const Vec3 center =
        axes * (place.pos + place.axes * Eigen::Map<const Vec3>(model.body_ipos + 3 * body));
    const Eigen::Map<const Vec3> principal(model.body_inertia + 3 * body);
    lump.add(model.body_mass[body], center, own * principal.asDiagonal() * own.transpose());
  }
  return lump;
}

int last_robot_body(const mjModel& model) {
  int last = model.jnt_bodyid[kRobotJoints - 1];
  for (int body = last + 1; body < model.nbody; ++body) {
    if (moving_body(model, body) == last) last = body;
  }
  return last;
}

void set_quat(const Eigen::Quaterniond& quat, double* to) {
  const double values[4] = {quat.w(), quat.x(), quat.y(), quat.z()};
  std::copy_n(values, 4, to);
}

// Of the fixed bodies between two joints.
Eigen::Quaterniond turn_between(const mjModel& model, int body, int carrier) {
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  for (; body != carrier; body = model.body_parentid[body]) {
    turn = quat_at(model.body_quat + 4 * body) * turn;
  }
  return turn;
}

void read_arm(const mjModel& model, int last_body, RobotModel& chain) {
  for (int joint = 0; joint < kArmJoints; ++joint) {
    const int body = model.jnt_bodyid[joint];
    const Eigen::Map<const Vec3> axis(model.jnt_axis + 3 * joint);
    const Eigen::Map<const Vec3> anchor(model.jnt_pos + 3 * joint);
    require(model.jnt_type[joint] == mjJNT_HINGE && axis == Vec3::UnitZ() && anchor.isZero(0) &&
                model.body_jntnum[body] == 1,
            "seven hinges about their bodies' z axes");
    const int carrier = joint == 0 ? 0 : model.jnt_bodyid[joint - 1];
    require(moving_body(model, model.body_parentid[body]) == carrier, "seven hinges in a row");
    Place place = place_in(model, body, carrier);
    if (joint == 0) place.pos -= Eigen::Map<const Vec3>(chain.base);
    const auto index = static_cast<std::size_t>(joint);
    set_link(lump_of(model, body, Mat3::Identity(), last_body), place, chain.arm[index]);
    set_quat(turn_between(model, body, carrier), chain.quat[index]);
  }
}

void read_fingers(const mjModel& model, int last_body, RobotModel& chain) {
  const int last_link = model.jnt_bodyid[kArmJoints - 1];
  for (int finger = 0; finger < kFingers; ++finger) {
    const int joint = kArmJoints + finger;
    const int body = model.jnt_bodyid[joint];
    require(model.jnt_type[joint] == mjJNT_SLIDE && model.body_jntnum[body] == 1 &&
                moving_body(model, model.body_parentid[body]) == last_link,
            "two fingers that slide on the last link");
    const Place place = place_in(model, body, last_link);
    const auto index = static_cast<std::size_t>(finger);
    set_link(lump_of(model, body, place.axes, last_body), place, chain.finger[index]);
    Eigen::Map<Vec3>(chain.slide[index]) =
        place.axes * Eigen::Map<const Vec3>(model.jnt_axis + 3 * joint);
  }
}

}  // namespace

RobotModel load_robot_model(const mjModel& model) {
  require(model.njnt >= kRobotJoints, "seven hinges and two fingers");
  RobotModel chain;
  const int first = model.jnt_bodyid[0];
  require(model.body_parentid[first] > 0, "a base");
  std::copy_n(model.body_pos + 3 * model.body_rootid[first], 3, chain.base);
  const int last_body = last_robot_body(model);
  read_arm(model, last_body, chain);
  read_fingers(model, last_body, chain);

  const int site = mj_name2id(&model, mjOBJ_SITE, "tcp");
  require(site >= 0, "a site named 'tcp'");
  const int last_link = model.jnt_bodyid[kArmJoints - 1];
  const int body = model.site_bodyid[site];
  require(moving_body(model, body) == last_link, "a TCP on the last link");
  const Place place = place_in(model, body, last_link);
  Eigen::Map<Vec3>(chain.tool_offset) =
      place.pos + place.axes * Eigen::Map<const Vec3>(model.site_pos + 3 * site);
  set_quat(turn_between(model, body, last_link) * quat_at(model.site_quat + 4 * site),
           chain.tool_quat);
  return chain;
}

}  // namespace engram
