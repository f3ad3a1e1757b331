// MuJoCo's contacts as rows of a solver: how bodies' velocities make points part or slip, how stiff
// that is, and at which acceleration it should go on. The numbers are MuJoCo's; contacts, and what
// is known of each row, stand where MuJoCo has them: efc_vel, efc_KBIP, efc_R, efc_D, efc_aref,
// efc_force, and each contact's efc_address. Only the Jacobian has a form of our own.
#pragma once

#include <mujoco/mujoco.h>

#include <span>
#include <vector>

#include "core/contact/cone_solver.h"
#include "core/contact/contact_filter.h"
#include "core/scene/scene_model.h"

namespace engram {

// What moves in a scene: the robot is 0; the prop in slot i is i + 1.
constexpr int kRobotBody = 0;
constexpr int kNoBody = -1;

class ContactConstraints {
 public:
  struct Contact {
    ConeContact cone;                    // where its movers begin is up to the islands
    int index = 0;                       // in MuJoCo's contacts
    int movers[2] = {kNoBody, kNoBody};  // in ascending order; at least one
  };

  // Room for what these scenes can have.
  explicit ContactConstraints(std::span<const SceneModel> scenes);

  int most_movers() const { return static_cast<int>(contacts_of_.size()); }
  int most_contacts() const { return static_cast<int>(contacts_.size()); }
  int most_rows() const { return static_cast<int>(jacobian_.size()) / kRowWidth; }

  // Makes rows of MuJoCo's contacts. Contacts with gliders meet them at their velocities; MuJoCo
  // takes kinematic bodies to stand still. If there are too many rows, MuJoCo's warning is set.
  void build(const SceneModel& scene, mjData& data, std::span<const KinematicBody> gliders);

  std::span<Contact> contacts() { return {contacts_.data(), count_}; }
  std::span<const Contact> contacts() const { return {contacts_.data(), count_}; }
  // How many contacts a mover has.
  int contacts_of(int mover) const { return contacts_of_[static_cast<std::size_t>(mover)]; }
  const double* jacobian() const { return jacobian_.data(); }  // kRowWidth numbers per row

 private:
  void add(const SceneModel& scene, mjData& data, int index);

  std::vector<Contact> contacts_;
  std::size_t count_ = 0;
  std::vector<int> contacts_of_;
  std::vector<double> jacobian_;
};

}  // namespace engram
