#include "core/contact/contact_constraints.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/math/dense.h"
#include "core/robot/robot_params.h"

namespace engram {
namespace {

using Axes = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Vec3 = Eigen::Vector3d;

std::size_t at(int index) { return static_cast<std::size_t>(index); }

// One side of a contact: a body, and with which sign its velocity counts.
struct Side {
  int body = 0;
  int mover = kNoBody;
  double sign = 1;
};

Side side_of(const SceneModel& scene, int geom, double sign) {
  const int body = scene.model->geom_bodyid[geom];
  const int slot = scene.slot_of_body[at(body)];
  if (slot >= 0) return {body, slot + 1, sign};
  return {body, scene.joints_of_body[at(body)] != 0 ? kRobotBody : kNoBody, sign};
}

// --- Jacobians ---

// Rows of a free body: its velocity in world axes, and its spin in its own.
void add_prop(const mjData& data, const mjContact& contact, const Side& side, double* rows) {
  const Eigen::Map<const Axes> frame(contact.frame);
  const Eigen::Map<const Axes> axes(data.xmat + 9 * side.body);
  const Vec3 lever =
      Eigen::Map<const Vec3>(contact.pos) - Eigen::Map<const Vec3>(data.xpos + 3 * side.body);
  const Vec3 lever_in_body = axes.transpose() * lever;
  for (int k = 0; k < contact.dim; ++k) {
    const Vec3 direction = side.sign * frame.row(k % 3).transpose();
    const Vec3 in_body = axes.transpose() * direction;
    double* const row = rows + k * kRowWidth;
    const Vec3 linear = k < 3 ? direction : Vec3(Vec3::Zero());
    const Vec3 angular = k < 3 ? lever_in_body.cross(in_body) : in_body;
    std::copy_n(linear.data(), 3, row);
    std::copy_n(angular.data(), 3, row + 3);
  }
}

// Rows of the robot's joints, each of which moves the first body, the second one, both or none.
void add_robot(const SceneModel& scene, const mjData& data, const mjContact& contact,
               const Side (&sides)[2], double* rows) {
  const Eigen::Map<const Axes> frame(contact.frame);
  const Eigen::Map<const Vec3> point(contact.pos);
  for (int k = 0; k < contact.dim; ++k) std::fill_n(rows + k * kRowWidth, kRobotWidth, 0.0);
  for (int joint = 0; joint < kRobotJoints; ++joint) {
    double sign = 0;
    for (const Side& side : sides) {
      const bool moves = ((scene.joints_of_body[at(side.body)] >> joint) & 1) != 0;
      if (moves) sign += side.sign;
    }
    if (sign == 0) continue;
    const Eigen::Map<const Vec3> axis(data.xaxis + 3 * joint);
    const bool turns = scene.model->jnt_type[joint] == mjJNT_HINGE;
    const Vec3 lever = point - Eigen::Map<const Vec3>(data.xanchor + 3 * joint);
    const Vec3 moving = turns ? axis.cross(lever) : Vec3(axis);
    const Vec3 linear = frame * (sign * moving);
    for (int k = 0; k < std::min(contact.dim, 3); ++k) rows[k * kRowWidth + joint] = linear[k];
    if (contact.dim <= 3 || !turns) continue;
    const Vec3 angular = frame * (sign * axis);
    for (int k = 3; k < contact.dim; ++k) rows[k * kRowWidth + joint] = angular[k - 3];
  }
}

// What moves of a contact, in ascending order; the robot counts once. Returns how many there are.
int movers_of(const Side (&sides)[2], Side (&movers)[2]) {
  int count = 0;
  for (const Side& side : sides) {
    if (side.mover != kNoBody) movers[count++] = side;
  }
  if (count < 2) return count;
  if (movers[1].mover < movers[0].mover) std::swap(movers[0], movers[1]);
  if (movers[0].mover != movers[1].mover) return 2;
  movers[1] = {};
  return 1;
}

// velocities of rows += rows * velocity of the mover
template <int kWidth>
void add_velocity(const mjtNum* velocity, int count, const ConeContact& cone, const double* rows,
                  mjtNum* sums) {
  double local[kWidth] = {};
  std::copy_n(velocity, count, local);
  for (int k = 0; k < cone.dim; ++k) sums[cone.row + k] += dot(rows + k * kRowWidth, local, kWidth);
}

// Velocity of the contact's second body less that of the first, as far as they glide.
Vec3 gliding_velocity(const mjModel& model, const mjContact& contact,
                      std::span<const KinematicBody> gliders) {
  Vec3 velocity = Vec3::Zero();
  const int first = model.body_mocapid[model.geom_bodyid[contact.geom1]];
  const int second = model.body_mocapid[model.geom_bodyid[contact.geom2]];
  for (const KinematicBody& glider : gliders) {
    if (glider.mocap == first) velocity -= glider.velocity;
    if (glider.mocap == second) velocity += glider.velocity;
  }
  return velocity;
}

// --- MuJoCo's impedance: how much of a violation a row mends, by how deep it is ---

double power(double base, double exponent) {
  double result = 1;
  for (; exponent > 0; --exponent) result *= base;
  return result;
}

double impedance(const mjContact& contact) {
  const auto within = [](double value) { return std::clamp(value, mjMINIMP, mjMAXIMP); };
  const double least = within(contact.solimp[0]);
  const double most = within(contact.solimp[1]);
  const double width = std::max(0.0, contact.solimp[2]);
  const double middle = within(contact.solimp[3]);
  const double exponent = std::max(1.0, contact.solimp[4]);
  if (least == most || width <= mjMINVAL) return 0.5 * (least + most);
  const double x = std::abs((contact.dist - contact.includemargin) / width);
  if (x >= 1) return most;
  if (x <= 0) return least;
  double y = x;
  if (exponent != 1) {
    y = x <= middle ? power(x, exponent) / power(middle, exponent - 1)
                    : 1 - power(1 - x, exponent) / power(1 - middle, exponent - 1);
  }
  return least + y * (most - least);
}

// Sets mu of the contact, and R, D and K, B, I of its rows.
void describe_rows(const mjModel& model, mjData& data, mjContact& contact) {
  const int row = contact.efc_address;
  const double time = std::max(contact.solref[0], 2 * model.opt.timestep);
  const double ratio = contact.solref[1];
  const double most = std::clamp(contact.solimp[1], mjMINIMP, mjMAXIMP);
  const double share = impedance(contact);
  const double give = model.body_invweight0[2 * model.geom_bodyid[contact.geom1]] +
                      model.body_invweight0[2 * model.geom_bodyid[contact.geom2]];
  mjtNum* const softness = data.efc_R + row;
  softness[0] = std::max(mjMINVAL, (1 - share) * give / share);
  if (contact.dim > 1) {
    softness[1] = softness[0] / std::max(mjMINVAL, model.opt.impratio);
    const mjtNum* const friction = contact.friction;
    contact.mu = friction[0] * std::sqrt(softness[1] / softness[0]);
    for (int k = 2; k < contact.dim; ++k) {
      softness[k] = softness[1] * friction[0] * friction[0] / (friction[k - 1] * friction[k - 1]);
    }
  }
  const double spring = 1 / std::max(mjMINVAL, most * most * time * time * ratio * ratio);
  const double damper = 2 / std::max(mjMINVAL, most * time);
  for (int k = 0; k < contact.dim; ++k) {
    data.efc_D[row + k] = 1 / softness[k];
    mjtNum* const law = data.efc_KBIP + 4 * (row + k);
    law[0] = k == 0 ? spring : 0;
    law[1] = damper;
    law[2] = share;
  }
}

// Velocities, and the accelerations that they call for.
void refer_rows(mjData& data, const mjContact& contact, const Vec3& gliding) {
  const Vec3 velocity = Eigen::Map<const Axes>(contact.frame) * gliding;
  for (int k = 0; k < contact.dim; ++k) {
    const int row = contact.efc_address + k;
    if (k < 3) data.efc_vel[row] += velocity[k];
    const mjtNum* const law = data.efc_KBIP + 4 * row;
    const double depth = k == 0 ? contact.dist - contact.includemargin : 0;
    data.efc_aref[row] = -law[1] * data.efc_vel[row] - law[0] * law[2] * depth;
  }
}

}  // namespace

ContactConstraints::ContactConstraints(std::span<const SceneModel> scenes) {
  std::size_t contacts = 0;
  std::size_t rows = 0;
  std::size_t movers = 1;
  for (const SceneModel& scene : scenes) {
    contacts = std::max(contacts, at(scene.model->nconmax));
    rows = std::max(rows, at(scene.model->njmax));
    movers = std::max(movers, scene.slots.size() + 1);
  }
  contacts_.resize(contacts);
  contacts_of_.resize(movers);
  jacobian_.resize(rows * kRowWidth);
}

void ContactConstraints::add(const SceneModel& scene, mjData& data, int index) {
  mjContact& contact = data.contact[index];
  const Side sides[2] = {side_of(scene, contact.geom1, -1), side_of(scene, contact.geom2, 1)};
  Side movers[2];
  const int count = movers_of(sides, movers);
  if (count == 0) return;
  contact.efc_address = data.nefc;
  data.nefc += contact.dim;
  describe_rows(*scene.model, data, contact);

  Contact& entry = contacts_[count_++];
  entry.index = index;
  ConeContact& cone = entry.cone;
  cone.dim = contact.dim;
  cone.row = contact.efc_address;
  cone.mu = contact.mu;
  std::copy_n(contact.friction, cone.friction.size(), cone.friction.begin());
  std::fill_n(data.efc_vel + cone.row, cone.dim, 0.0);
  double* rows = jacobian_.data() + at(cone.row) * kRowWidth;
  for (int i = 0; i < 2; ++i) {
    const Side& mover = movers[i];
    entry.movers[i] = mover.mover;
    cone.width[at(i)] = 0;
    if (mover.mover == kNoBody) continue;
    ++contacts_of_[at(mover.mover)];
    if (mover.mover == kRobotBody) {
      add_robot(scene, data, contact, sides, rows);
      add_velocity<kRobotWidth>(data.qvel, kRobotJoints, cone, rows, data.efc_vel);
      cone.width[at(i)] = kRobotWidth;
    } else {
      add_prop(data, contact, mover, rows);
      add_velocity<kPropWidth>(data.qvel + scene.slots[at(mover.mover - 1)].dof, kPropWidth, cone,
                               rows, data.efc_vel);
      cone.width[at(i)] = kPropWidth;
    }
    rows += cone.width[at(i)];
  }
}

void ContactConstraints::build(const SceneModel& scene, mjData& data,
                               std::span<const KinematicBody> gliders) {
  count_ = 0;
  data.ne = data.nf = data.nefc = 0;
  std::fill_n(contacts_of_.begin(), scene.slots.size() + 1, 0);
  for (int i = 0; i < data.ncon; ++i) {
    if (data.contact[i].exclude != 0) continue;
    if (data.nefc + data.contact[i].dim > scene.model->njmax) {
      ++data.warning[mjWARN_CNSTRFULL].number;
      break;
    }
    add(scene, data, i);
  }
  for (const Contact& entry : contacts()) {
    const mjContact& contact = data.contact[entry.index];
    refer_rows(data, contact, gliding_velocity(*scene.model, contact, gliders));
  }
}

}  // namespace engram
