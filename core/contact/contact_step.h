// Contacts of one environment in one substep: finds them, hands them to the solver's lanes, and
// keeps what the contact law remembers.
#pragma once

#include <cstdint>
#include <vector>

#include "core/contact/contact_block.h"
#include "core/contact/narrow_phase.h"

namespace engram {

enum class BodyPresence : std::uint8_t {
  kAbsent,   // hidden
  kResting,  // a free prop that is asleep: not simulated
  kPresent,  // simulated, or moved by the task
};

// Bodies of an environment at a substep's start, by index of the CollisionScene.
struct BodyStates {
  explicit BodyStates(const CollisionScene& scene);

  std::vector<BodyPresence> presence;
  std::vector<Frame> frames;               // of the bodies' origins, world
  std::vector<int> slots;                  // of free bodies in the solver, or -1
  std::vector<Vec3> kinematic_velocities;  // m/s
  std::vector<double> speeds;              // upper bounds of any point's, m/s
};

// What the contact law remembers of an environment: pairs of shapes, in the order in which they
// came near each other, which is that of solving.
struct ContactMemory {
  std::vector<ContactPair> pairs;
};

// Pairs that an environment can remember; those that came near last are left out.
int max_contact_pairs(const CollisionScene& scene);

class ContactStep {
 public:
  // Working memory of one lane.
  explicit ContactStep(const CollisionScene& scene);

  // Finds all contacts and adds them to the lane. Call it within a MujocoScope.
  void find(const BodyStates& bodies, ContactMemory& memory, NarrowPhase& narrow_phase,
            double timestep, int lane, ContactBlock& block);
  // After the substep: drops patches that slipped.
  void finish(ContactMemory& memory, int lane, const ContactBlock& block) const;
  // Tests for contacts in this substep.
  bool empty() const { return refs_.empty(); }

  // Calls `add(prop, finger, impulse)` for each patch between a prop and a finger: impulse on the
  // finger, N s, world.
  template <class Add>
  void for_finger_impulses(int lane, const ContactBlock& block, const Add& add) const {
    for (const Ref& ref : refs_) {
      const CollisionBody& a = body_of(ref.shape_a);
      const CollisionBody& b = body_of(ref.shape_b);
      if (b.prop >= 0 && finger_of(a.link) >= 0) {
        add(b.prop, finger_of(a.link), block.impulse(lane, ref.patch));
      }
    }
  }

 private:
  // A pair of shapes near each other in this substep.
  struct Near {
    int record = 0;  // of the memory
    int shape_pair = 0;
    ContactPoints points;
    double gap = 0;  // least, m
  };
  struct Ref {
    int patch = 0;
    int record = 0;
    int index = 0;  // of the record's patches
    int shape_a = 0;
    int shape_b = 0;
  };

  const CollisionBody& body_of(int shape) const {
    return scene_.bodies()[static_cast<std::size_t>(
        scene_.shapes()[static_cast<std::size_t>(shape)].body)];
  }
  void find_near(const BodyStates& bodies, ContactMemory& memory, NarrowPhase& narrow_phase);
  void find_body_pair(const BodyPair& pair, const BodyStates& bodies, ContactMemory& memory,
                      NarrowPhase& narrow_phase);
  void sort_new(int known, ContactMemory& memory);
  void forget_distant(const BodyStates& bodies, ContactMemory& memory);
  void add_patches(const Near& near, const BodyStates& bodies, ContactMemory& memory,
                   double timestep, int lane, ContactBlock& block);

  const CollisionScene& scene_;
  std::vector<Near> near_;
  std::vector<Ref> refs_;
  std::vector<std::uint8_t> kept_;  // of the memory's pairs
  std::vector<int> new_place_;
  std::vector<ContactPair> added_;
};

}  // namespace engram
