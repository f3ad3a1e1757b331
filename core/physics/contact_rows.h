// MuJoCo's contacts as rows of a solver: how bodies' velocities make points part or slip, how stiff
// that is, and at which acceleration it should go on. The numbers are MuJoCo's; contacts, and what
// is known of each row, stand where MuJoCo has them: efc_vel, efc_KBIP, efc_R, efc_D, efc_aref,
// efc_force, and each contact's efc_address. Only the Jacobian has a form of our own.
#pragma once

#include <mujoco/mujoco.h>

#include <span>
#include <vector>

#include "core/physics/cone_solver.h"
#include "core/physics/contacts.h"
#include "core/physics/scene_model.h"

namespace engram {

// What moves in a scene: the robot is 0; the prop in slot i is i + 1.
constexpr int kRobotMover = 0;
constexpr int kNoMover = -1;

class ContactRows {
 public:
  struct Contact {
    ConeContact cone;                      // where its movers begin is up to the islands
    int index = 0;                         // in MuJoCo's contacts
    int movers[2] = {kNoMover, kNoMover};  // in ascending order; at least one
  };

  // Room for what these scenes can have.
  explicit ContactRows(std::span<const SceneModel> scenes);

  int most_movers() const { return static_cast<int>(contacts_of_.size()); }
  int most_contacts() const { return static_cast<int>(contacts_.size()); }
  int most_rows() const { return static_cast<int>(jacobian_.size()) / kRowWidth; }

  // Makes rows of MuJoCo's contacts. Contacts with gliders meet them at their velocities; MuJoCo
  // takes kinematic bodies to stand still. If there are too many rows, MuJoCo's warning is set.
  void build(const SceneModel& scene, mjData& data, std::span<const Glider> gliders);

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

// Throws Error unless the rows of all pairs' contacts can be made: no powers of impedance that are
// not whole numbers, and time constants.
void require_plain_pairs(const mjModel& model);

}  // namespace engram
