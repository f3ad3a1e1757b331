// Broad phase of one environment: the pairs of shapes that are near each other, with their contact
// points.
#pragma once

#include <cstdint>
#include <vector>

#include "core/collision/contact_point.h"
#include "core/collision/narrow_phase.h"

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

  // Begins a control step.
  void begin();
  // Finds the pairs with points that can act in this substep, and those of fingers and balls that
  // are to be remembered. Remembers them, forgets others; keeps those of sleeping props. Call it
  // within a MujocoScope.
  void find(const BodyStates& bodies, ContactMemory& memory, NarrowPhase& narrow_phase,
            double timestep);
  // Calls `visit(near)` for each pair found, in the order of solving.
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (const int i : order_) visit(near_[static_cast<std::size_t>(i)]);
  }

 private:
  // What both bodies of a pair may have moved, m.
  struct Travel {
    double before = 0;   // in this control step, until this substep
    double substep = 0;  // in this substep

    double after() const { return before + substep; }
  };

  void advance_travel(const BodyStates& bodies, double timestep);
  bool visits_are_known(const BodyStates& bodies) const;
  void choose_visits(const BodyStates& bodies);
  Travel travel_of(int body_a, int body_b) const;
  std::uint64_t known_until(int body) const;
  const Frame& shape_frame(int shape, const BodyStates& bodies);
  const Vec3& center(int body, const BodyStates& bodies);
  double body_distance(const BodyPair& pair, double needed, const BodyStates& bodies);
  void find_body_pair(int pair, const BodyStates& bodies, ContactMemory& memory,
                      NarrowPhase& narrow_phase);
  void find_shape_pair(int pair, const Travel& travel, const BodyStates& bodies,
                       ContactMemory& memory, NarrowPhase& narrow_phase);
  void sort_new(int known, ContactMemory& memory);
  void forget_distant(const BodyStates& bodies, ContactMemory& memory);

  const CollisionScene& scene_;
  std::vector<double> near_gap_;         // of each shape pair: what it is remembered from, m
  std::vector<double> bodies_near_gap_;  // the largest of each body pair
  std::vector<NearPair> near_;
  std::vector<Travel> travel_;  // of each body
  // Travel of both bodies up to which a pair cannot come near: body pairs, shape pairs.
  std::vector<double> bodies_clear_;
  // Body pairs to visit, ascending, while presences are these and each body's travel is at most
  // this; no other can come near.
  std::vector<int> visits_;
  std::vector<BodyPresence> visit_presence_;
  std::vector<double> visit_travel_;
  std::vector<double> shapes_clear_;    // set for body pairs that have been near
  std::vector<std::uint8_t> was_near_;  // body pairs, in this control step
  std::vector<Frame> shape_frames_;
  std::vector<std::uint8_t> turned_;  // shapes whose axes are not the body's
  std::vector<Vec3> centers_;         // of the bodies' bounding spheres, world
  // Searches until which a shape's frame and a body's centre are known.
  std::vector<std::uint64_t> posed_;
  std::vector<std::uint64_t> centered_;
  std::uint64_t search_ = 0;        // counts them
  std::vector<std::uint8_t> kept_;  // of the memory's pairs
  std::vector<int> order_;          // of near_
  std::vector<int> moved_to_;       // of the memory's pairs
  std::vector<ContactPair> added_;
  ContactPair added_pair_;  // one that may be added
};

}  // namespace engram
