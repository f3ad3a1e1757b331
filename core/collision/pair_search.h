// Contact points of one environment, and the pairs of shapes that it remembers.
#pragma once

#include <cstdint>
#include <vector>

#include "core/collision/broad_phase.h"
#include "core/collision/contact_point.h"
#include "core/collision/narrow_phase.h"

namespace engram {

// Bodies of an environment at a substep's start, by index of the CollisionScene.
struct BodyStates {
  explicit BodyStates(const CollisionScene& scene);

  std::vector<BodyPresence> presence;
  std::vector<Frame> frames;               // of the bodies' origins, world
  std::vector<int> body_indices;           // of free bodies in the solver, or -1
  std::vector<Vec3> kinematic_velocities;  // m/s
  std::vector<double> speeds;              // upper bounds of any point's, m/s
};

// What the contact law remembers of an environment: pairs of shapes, in the order in which they
// came near each other, which is that of solving. A finger is near a ball long before it can act.
struct ContactMemory {
  std::vector<ContactPair> pairs;
};

// Most pairs that are near at once, and most of them that an environment remembers from step to
// step. Of more, those that came near last are left out.
int max_near_pairs(const CollisionScene& scene);
int max_stored_pairs(const CollisionScene& scene);

// A pair of shapes near each other in this substep.
struct NearPair {
  NearPair(int of_record, int of_shapes, double at_most)
      : record(of_record), shape_pair(of_shapes), gap(at_most) {}

  int record;  // of the memory
  int shape_pair;
  ContactPoints points;  // that can act in this substep
  double gap;            // least, m
};

class PairSearch {
 public:
  // Working memory of one lane.
  explicit PairSearch(const CollisionScene& scene);

  // Finds, among those that the broad phase found in a lane, the pairs with points that can act in
  // this substep, and those of fingers and balls that are to be remembered. Remembers them, forgets
  // others; keeps those of sleeping props. Call it within a MujocoScope.
  void find(const BodyStates& bodies, const BroadPhase& broad_phase, int lane,
            ContactMemory& memory, NarrowPhase& narrow_phase);
  // Calls `visit(near)` for each pair found, in the order of solving.
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (const int i : order_) visit(near_[static_cast<std::size_t>(i)]);
  }

 private:
  std::uint64_t known_until(int body) const;
  const Frame& shape_frame(int shape, const BodyStates& bodies);
  void find_shape_pair(int pair, const BroadPhaseLanes::ShapePair& limits, double travel,
                       const BodyStates& bodies, ContactMemory& memory, NarrowPhase& narrow_phase);
  void sort_new(int known, ContactMemory& memory);
  void forget_distant(const BodyStates& bodies, ContactMemory& memory);

  const CollisionScene& scene_;
  std::vector<NearPair> near_;
  std::vector<Frame> shape_frames_;
  std::vector<std::uint8_t> turned_;  // shapes whose axes are not the body's
  std::vector<std::uint64_t> posed_;  // searches until which shapes' frames are known
  std::uint64_t search_ = 0;          // counts them
  std::vector<std::uint8_t> kept_;    // of the memory's pairs
  std::vector<int> order_;            // of near_
  std::vector<int> moved_to_;         // of the memory's pairs
  std::vector<ContactPair> added_;
  ContactPair added_pair_;  // one that may be added
};

}  // namespace engram
