#include "core/contact/contact_constraints.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/base/index.h"
#include "core/math/dense.h"
#include "core/math/eigen_types.h"
#include "core/robot/robot_params.h"

namespace engram {
namespace {

using Axes = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// One side of a contact: a MuJoCo body, the dynamic body that it belongs to, and the sign of its
// velocity.
struct Side {
  int body = 0;
  int dynamic_body = kNoBody;
  double sign = 1;
};

Side side_of(const SceneModel& scene, int geom, double sign) {
  const int body = scene.model->geom_bodyid[geom];
  const int slot = scene.slot_of_body[at(body)];
  if (slot >= 0) return {body, slot + 1, sign};
  return {body, scene.joints_of_body[at(body)] != 0 ? kRobotBody : kNoBody, sign};
}

// --- Jacobians ---

// Writes the rows of a free body: linear velocity in world axes, angular velocity in body axes.
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

// Writes the rows of the robot's joints, each of which moves the first body, the second one, both
// or none.
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

// Selects the dynamic sides of a contact, in ascending order of bodies; the robot counts once.
// Returns their number.
int dynamic_sides(const Side (&sides)[2], Side (&dynamic)[2]) {
  int count = 0;
  for (const Side& side : sides) {
    if (side.dynamic_body != kNoBody) dynamic[count++] = side;
  }
  if (count < 2) return count;
  if (dynamic[1].dynamic_body < dynamic[0].dynamic_body) std::swap(dynamic[0], dynamic[1]);
  if (dynamic[0].dynamic_body != dynamic[1].dynamic_body) return 2;
  dynamic[1] = {};
  return 1;
}

// sums += rows * velocity of the dynamic body
template <int kWidth>
void add_velocity(const mjtNum* velocity, int count, const ConeContact& cone, const double* rows,
                  mjtNum* sums) {
  double local[kWidth] = {};
  std::copy_n(velocity, count, local);
  for (int k = 0; k < cone.dim; ++k) sums[cone.row + k] += dot(rows + k * kRowWidth, local, kWidth);
}

// Velocity of the contact's second body minus that of the first, as far as they are kinematic.
Vec3 kinematic_velocity(const mjModel& model, const mjContact& contact,
                        std::span<const KinematicBody> kinematic_bodies) {
  Vec3 velocity = Vec3::Zero();
  const int first = model.body_mocapid[model.geom_bodyid[contact.geom1]];
  const int second = model.body_mocapid[model.geom_bodyid[contact.geom2]];
  for (const KinematicBody& body : kinematic_bodies) {
    if (body.mocap == first) velocity -= body.velocity;
    if (body.mocap == second) velocity += body.velocity;
  }
  return velocity;
}

// --- MuJoCo's impedance: share of a violation that a row corrects, as a function of depth ---

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

// Sets the contact's mu, and regularization R, its inverse D and K, B, I of its rows.
void set_impedance(const mjModel& model, mjData& data, mjContact& contact) {
  const int row = contact.efc_address;
  const double time = std::max(contact.solref[0], 2 * model.opt.timestep);
  const double ratio = contact.solref[1];
  const double most = std::clamp(contact.solimp[1], mjMINIMP, mjMAXIMP);
  const double share = impedance(contact);
  const double inv_weight = model.body_invweight0[2 * model.geom_bodyid[contact.geom1]] +
                            model.body_invweight0[2 * model.geom_bodyid[contact.geom2]];
  mjtNum* const regularization = data.efc_R + row;
  regularization[0] = std::max(mjMINVAL, (1 - share) * inv_weight / share);
  if (contact.dim > 1) {
    regularization[1] = regularization[0] / std::max(mjMINVAL, model.opt.impratio);
    const mjtNum* const friction = contact.friction;
    contact.mu = friction[0] * std::sqrt(regularization[1] / regularization[0]);
    for (int k = 2; k < contact.dim; ++k) {
      regularization[k] =
          regularization[1] * friction[0] * friction[0] / (friction[k - 1] * friction[k - 1]);
    }
  }
  const double spring = 1 / std::max(mjMINVAL, most * most * time * time * ratio * ratio);
  const double damper = 2 / std::max(mjMINVAL, most * time);
  for (int k = 0; k < contact.dim; ++k) {
    data.efc_D[row + k] = 1 / regularization[k];
    mjtNum* const kbip = data.efc_KBIP + 4 * (row + k);
    kbip[0] = k == 0 ? spring : 0;
    kbip[1] = damper;
    kbip[2] = share;
  }
}

// Adds kinematic motion to the rows' velocities and sets their reference accelerations.
void set_reference_acceleration(mjData& data, const mjContact& contact, const Vec3& kinematic) {
  const Vec3 velocity = Eigen::Map<const Axes>(contact.frame) * kinematic;
  for (int k = 0; k < contact.dim; ++k) {
    const int row = contact.efc_address + k;
    if (k < 3) data.efc_vel[row] += velocity[k];
    const mjtNum* const kbip = data.efc_KBIP + 4 * row;
    const double depth = k == 0 ? contact.dist - contact.includemargin : 0;
    data.efc_aref[row] = -kbip[1] * data.efc_vel[row] - kbip[0] * kbip[2] * depth;
  }
}

}  // namespace

ContactConstraints::ContactConstraints(std::span<const SceneModel> scenes) {
  std::size_t contacts = 0;
  std::size_t rows = 0;
  std::size_t bodies = 1;
  for (const SceneModel& scene : scenes) {
    contacts = std::max(contacts, at(scene.model->nconmax));
    rows = std::max(rows, at(scene.model->njmax));
    bodies = std::max(bodies, scene.slots.size() + 1);
  }
  contacts_.resize(contacts);
  contacts_of_.resize(bodies);
  jacobian_.resize(rows * kRowWidth);
}

void ContactConstraints::add(const SceneModel& scene, mjData& data, int index) {
  mjContact& contact = data.contact[index];
  const Side sides[2] = {side_of(scene, contact.geom1, -1), side_of(scene, contact.geom2, 1)};
  Side dynamic[2];
  const int count = dynamic_sides(sides, dynamic);
  if (count == 0) return;
  contact.efc_address = data.nefc;
  data.nefc += contact.dim;
  set_impedance(*scene.model, data, contact);

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
    const Side& side = dynamic[i];
    entry.bodies[i] = side.dynamic_body;
    cone.width[at(i)] = 0;
    if (side.dynamic_body == kNoBody) continue;
    ++contacts_of_[at(side.dynamic_body)];
    if (side.dynamic_body == kRobotBody) {
      add_robot(scene, data, contact, sides, rows);
      add_velocity<kRobotWidth>(data.qvel, kRobotJoints, cone, rows, data.efc_vel);
      cone.width[at(i)] = kRobotWidth;
    } else {
      add_prop(data, contact, side, rows);
      add_velocity<kPropWidth>(data.qvel + scene.slots[at(side.dynamic_body - 1)].dof, kPropWidth,
                               cone, rows, data.efc_vel);
      cone.width[at(i)] = kPropWidth;
    }
    rows += cone.width[at(i)];
  }
}

void ContactConstraints::build(const SceneModel& scene, mjData& data,
                               std::span<const KinematicBody> kinematic_bodies) {
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
    set_reference_acceleration(data, contact,
                               kinematic_velocity(*scene.model, contact, kinematic_bodies));
  }
}

}  // namespace engram
