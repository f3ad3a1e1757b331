// Broad phase of a block of lanes: which pairs of shapes are near each other in a substep.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/aligned_array.h"
#include "core/base/index.h"
#include "core/collision/broad_phase_lanes.h"
#include "core/scene/collision_scene.h"

namespace engram {

// Speculative contacts act before shapes touch. A point whose gap is larger than this and
// the displacement of the bodies in a substep does nothing: shapes with no nearer points are not
// near each other.
inline constexpr double kActiveGap = 0.0025;  // m
// Bodies of the robot touch one another at no larger gap than this.
inline constexpr double kMaxSelfGap = 0.009;  // m

// Gap below which a pair of shapes is near, m: that of a finger and a free ball is large.
double near_gap_of(const CollisionScene& scene, const ShapePair& pair);

enum class BodyPresence : std::uint8_t {
  kAbsent,   // hidden
  kResting,  // a free prop that is asleep: not simulated
  kPresent,  // simulated, or moved by the task
};

class BroadPhase {
 public:
  BroadPhase(const CollisionScene& scene, double timestep, int lanes);

  // Begins a substep, in which no lane takes part.
  void clear();
  // A lane takes part, with these bodies.
  void enter(int lane, const std::vector<BodyPresence>& presence);
  // Pose of a prop's body; `speed`: upper bound of any point's, m/s. Kept until it is put again.
  void put(int lane, int body, const Frame& frame, double speed);
  // Upper bounds of the speed of any point of a body, or of all links, m/s, and of what a body
  // moves in this substep, m.
  double speed(int lane, int body) const { return value(lane, body, BroadPhaseLanes::kSpeed); }
  double fastest_link(int lane) const;
  double travel(int lane, int body) const { return value(lane, body, BroadPhaseLanes::kTravel); }

  // From which gap on a pair of shapes is near.
  const BroadPhaseLanes::ShapePair& limits(int shape_pair) const {
    return shape_pairs_[at(shape_pair)];
  }

  // For ContactKernel::pose_robot and find_near.
  BroadPhaseLanes& view() { return view_; }
  // The result: ascending pairs.
  std::span<const NearShapes> near() const { return {near_.data(), at(view_.num_near)}; }

 private:
  double value(int lane, int body, int row) const {
    return bodies_[at((BroadPhaseLanes::kBodyRows * body + row) * lanes_ + lane)];
  }
  void put_static();
  void put_rows(AlignedArray<double>& rows, int first, int lane, const double* values, int count);
  void put_frame(AlignedArray<double>& rows, int index, int lane, const Frame& frame);

  int lanes_;
  std::vector<BroadPhaseLanes::Body> body_models_;
  std::vector<BroadPhaseLanes::Shape> shape_models_;
  std::vector<BroadPhaseLanes::ShapePair> shape_pairs_;
  std::vector<BroadPhaseLanes::BodyPair> body_pairs_;
  AlignedArray<double> frames_;
  AlignedArray<double> bodies_;
  AlignedArray<double> shapes_;
  AlignedArray<bool> is_posed_;
  std::vector<unsigned> present_;
  std::vector<NearShapes> near_;
  BroadPhaseLanes view_;
};

}  // namespace engram
