// Contacts of one environment in one substep: finds them, hands them to the solver's lanes, and
// keeps what the contact law remembers.
#pragma once

#include <vector>

#include "core/base/index.h"
#include "core/collision/pair_search.h"
#include "core/contact/contact_block.h"

namespace engram {

class ContactStep {
 public:
  // Working memory of one lane.
  explicit ContactStep(const CollisionScene& scene);

  // Finds all contacts, after the broad phase, and adds them to the lane. Call it within a
  // MujocoScope.
  void find(const BodyStates& bodies, const BroadPhase& broad_phase, ContactMemory& memory,
            NarrowPhase& narrow_phase, int lane, ContactBlock& block);
  // After the substep: drops patches that slipped.
  void finish(ContactMemory& memory, int lane, const ContactBlock& block) const;
  // Tests for contacts in this substep.
  bool empty() const { return refs_.empty(); }
  // Orders environments by this substep's patches, so that those with like ones move side by side:
  // by the time that all take, in which the robot counts twice, then by the number in each list.
  int work() const {
    const int time = 2 * num_moving_ + num_fixed_ + 2 * num_links();
    return (time * kMaxOfList + num_moving_) * kMaxOfList + num_fixed_;
  }

  // Calls `add(prop, finger, impulse)` for each patch between a prop and a finger: impulse on the
  // finger, N s, world.
  template <class Add>
  void for_finger_impulses(int lane, const ContactBlock& block, const Add& add) const {
    for (const Ref& ref : refs_) {
      const ShapePair& shapes = scene_.shape_pairs()[at(ref.shape_pair)];
      const CollisionBody& a = body_of(shapes.a);
      const CollisionBody& b = body_of(shapes.b);
      if (b.prop >= 0 && finger_of(a.link) >= 0) {
        add(b.prop, finger_of(a.link), block.impulse(lane, ref.patch));
      }
    }
  }

 private:
  static constexpr int kMaxOfList = 256;

  struct Ref {
    int patch = 0;
    int record = 0;
    int index = 0;  // of the record's patches
    int shape_pair = 0;
  };

  int num_links() const { return static_cast<int>(refs_.size()) - num_moving_ - num_fixed_; }
  const CollisionBody& body_of(int shape) const {
    return scene_.bodies()[at(scene_.shapes()[at(shape)].body)];
  }
  void add_patches(const NearPair& near, const BodyStates& bodies, ContactMemory& memory, int lane,
                   ContactBlock& block);

  const CollisionScene& scene_;
  PairSearch search_;
  std::vector<Ref> refs_;
  // Patches between moving bodies, and between free and fixed ones.
  int num_moving_ = 0;
  int num_fixed_ = 0;
};

}  // namespace engram
