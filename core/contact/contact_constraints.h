// Contact constraints: rows of the solver made of MuJoCo's contacts, with Jacobian, regularization
// and reference acceleration. Values equal MuJoCo's and are stored in its arrays: efc_vel,
// efc_KBIP, efc_R, efc_D, efc_aref, efc_force, and each contact's efc_address. Only the Jacobian
// has a layout of its own: a dense block per dynamic body.
#pragma once

#include <mujoco/mujoco.h>

#include <span>
#include <vector>

#include "core/contact/cone_solver.h"
#include "core/contact/contact_filter.h"
#include "core/scene/scene_model.h"

namespace engram {

// Dynamic bodies of a scene: the robot is 0; the prop in slot i is i + 1.
constexpr int kRobotBody = 0;
constexpr int kNoBody = -1;

class ContactConstraints {
 public:
  struct Contact {
    ConeContact cone;                    // Islands sets its velocity ranges
    int index = 0;                       // in MuJoCo's contacts
    int bodies[2] = {kNoBody, kNoBody};  // dynamic ones, in ascending order; at least one
  };

  // Allocates for the largest of these scenes.
  explicit ContactConstraints(std::span<const SceneModel> scenes);

  int max_bodies() const { return static_cast<int>(contacts_of_.size()); }
  int max_contacts() const { return static_cast<int>(contacts_.size()); }
  int max_rows() const { return static_cast<int>(jacobian_.size()) / kRowWidth; }

  // Makes rows of MuJoCo's contacts. Contacts with moving kinematic bodies meet them at their
  // velocities; MuJoCo takes kinematic bodies to stand still. If there are too many rows, MuJoCo's
  // warning is set.
  void build(const SceneModel& scene, mjData& data,
             std::span<const KinematicBody> kinematic_bodies);

  std::span<Contact> contacts() { return {contacts_.data(), count_}; }
  std::span<const Contact> contacts() const { return {contacts_.data(), count_}; }
  // Number of contacts of a dynamic body.
  int contacts_of(int body) const { return contacts_of_[static_cast<std::size_t>(body)]; }
  const double* jacobian() const { return jacobian_.data(); }  // kRowWidth numbers per row

 private:
  void add(const SceneModel& scene, mjData& data, int index);

  std::vector<Contact> contacts_;
  std::size_t count_ = 0;
  std::vector<int> contacts_of_;
  std::vector<double> jacobian_;
};

}  // namespace engram
