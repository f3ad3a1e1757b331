#include "core/contact/coulomb_sliding.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cstddef>

#include "core/math/eigen_types.h"

namespace engram {
namespace {

using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Matrix cross_matrix(const Vec3& v) {
  Matrix m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// Point of a body at a contact, in the contact's axes, normal first; signs are of the contact's
// second body against the first.
struct ContactPoint {
  Vec3 acceleration;  // unconstrained, m/s^2
  Matrix mobility;    // acceleration by a force there, 1/kg
};

ContactPoint contact_point(const mjModel& model, const mjData& data, int body,
                           const mjContact& contact) {
  const Eigen::Map<const Matrix> axes(contact.frame);
  const Eigen::Map<const Vec3> pos(contact.pos);
  const Eigen::Map<const Matrix> body_axes(data.xmat + 9 * body);
  const Eigen::Map<const Matrix> inertia_axes(data.ximat + 9 * body);
  const Eigen::Map<const Vec3> inertia(model.body_inertia + 3 * body);
  const mjtNum* free = data.qacc_smooth + model.body_dofadr[body];
  const Vec3 angular_acceleration = body_axes * Eigen::Map<const Vec3>(free + 3);
  const Vec3 from_origin = pos - Eigen::Map<const Vec3>(data.xpos + 3 * body);
  const Matrix lever = cross_matrix(pos - Eigen::Map<const Vec3>(data.xipos + 3 * body));
  const Matrix turned =
      inertia_axes * inertia.cwiseInverse().asDiagonal() * inertia_axes.transpose();
  ContactPoint point;
  const double sign = model.geom_bodyid[contact.geom2] == body ? 1 : -1;
  point.acceleration =
      sign * axes * (Eigen::Map<const Vec3>(free) + angular_acceleration.cross(from_origin));
  point.mobility = axes * (Matrix::Identity() / model.body_mass[body] - lever * turned * lever) *
                   axes.transpose();
  return point;
}

// Sets the reference acceleration of the friction rows to the slip's under friction mu N, and a
// little less, so that the solver finds friction at its limit.
void set_friction_reference(const mjModel& model, mjData& data, const mjContact& contact,
                            int body) {
  const int row = contact.efc_address;
  const ContactPoint point = contact_point(model, data, body, contact);
  const double timestep = model.opt.timestep;
  const double compliance = point.mobility(0, 0) + data.efc_R[row];
  const double normal = (data.efc_aref[row] - point.acceleration[0]) / compliance;
  // Normal force without the part that stops a fall.
  const double arresting =
      -data.efc_KBIP[4 * row + 1] * std::min(data.efc_vel[row], 0.0) / compliance;
  const double pressing = normal - arresting;
  Vec3 slip(0, data.efc_vel[row + 1], data.efc_vel[row + 2]);
  slip.tail<2>() += timestep * point.acceleration.tail<2>();
  const double speed = slip.norm();
  if (pressing <= 0 || speed < mjMINVAL) return;
  const Vec3 direction = slip / speed;
  const double friction = contact.friction[0] * pressing;
  const Vec3 left =
      point.acceleration + point.mobility * (normal * Vec3::UnitX() - friction * direction);
  const Vec3 after(0, data.efc_vel[row + 1] + timestep * left[1],
                   data.efc_vel[row + 2] + timestep * left[2]);
  if (after.dot(direction) <= 0) return;  // it stops
  const double margin = (arresting > 0 ? 1 : 2) * data.efc_R[row + 1] * friction;
  for (int k = 1; k < 3; ++k) data.efc_aref[row + k] = left[k] - margin * direction[k];
}

}  // namespace

void apply_coulomb_sliding(const SceneModel& scene, mjData& data, const ContactConstraints& rows) {
  const mjModel& model = *scene.model;
  for (const ContactConstraints::Contact& entry : rows.contacts()) {
    const mjContact& contact = data.contact[entry.index];
    const int dynamic_body = entry.bodies[0];
    if (contact.dim < 3 || dynamic_body == kRobotBody || rows.contacts_of(dynamic_body) > 1)
      continue;
    const int body = scene.slots[static_cast<std::size_t>(dynamic_body - 1)].body;
    const bool on_world =
        model.geom_bodyid[contact.geom1] == 0 || model.geom_bodyid[contact.geom2] == 0;
    if (on_world) set_friction_reference(model, data, contact, body);
  }
}

}  // namespace engram
