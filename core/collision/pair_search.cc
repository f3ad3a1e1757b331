#include "core/collision/pair_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/index.h"
#include "core/scene/speculative_margin.h"

namespace engram {
namespace {

// Whatever a clearance calls clear is too far away for contacts.
static_assert(kMaxSelfGap < kSelfMargin);
static_assert(kActiveGap + kClearanceAllowance < kContactMargin);
// Points up to so much farther are looked for. MuJoCo's convex collision finds other points
// without, and wrong ones for reaches of several centimetres.
constexpr double kLookAhead = 0.01;  // m
// Pairs that come near in the same substep are solved from the nearest on, to this precision.
constexpr double kOrderPrecision = 1000;  // 1/m
constexpr double kUnknown = -1;           // a distance, m
constexpr std::uint64_t kForever = std::numeric_limits<std::uint64_t>::max();

// Gap between a box and a ball, m.
double gap_to_ball(const CollisionShape& box, const Frame& frame, const CollisionShape& ball,
                   const Vec3& center) {
  const Vec3 local = frame.axes.transpose() * (center - frame.pos);
  return (local - local.cwiseMin(box.half).cwiseMax(-box.half)).norm() - ball.bounding_radius;
}

// Index of what is remembered of a pair of shapes, or -1.
int record_of(int shape_pair, const ContactMemory& memory) {
  const auto found = std::find_if(memory.pairs.begin(), memory.pairs.end(),
                                  [&](const ContactPair& p) { return p.shape_pair == shape_pair; });
  return found == memory.pairs.end() ? -1 : static_cast<int>(found - memory.pairs.begin());
}

// Pairs that are remembered long before they can act.
int num_early_pairs(const CollisionScene& scene) {
  return static_cast<int>(std::ranges::count_if(scene.shape_pairs(), [&](const ShapePair& pair) {
    return near_gap_of(scene, pair) > kActiveGap;
  }));
}

}  // namespace

BodyStates::BodyStates(const CollisionScene& scene)
    : presence(scene.bodies().size(), BodyPresence::kPresent),
      frames(scene.bodies().size()),
      body_indices(scene.bodies().size(), -1),
      kinematic_velocities(scene.bodies().size(), Vec3::Zero()),
      speeds(scene.bodies().size(), 0) {
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i] = scene.bodies()[i].attachment.frame;  // of static ones
  }
}

int max_near_pairs(const CollisionScene& scene) {
  constexpr int kOfRobot = 48;
  constexpr int kOfShape = 4;
  return std::min(kOfRobot + kOfShape * scene.num_free_shapes() + num_early_pairs(scene),
                  static_cast<int>(scene.shape_pairs().size()));
}

int max_stored_pairs(const CollisionScene& scene) {
  constexpr int kOfRobot = 16;
  return std::min(kOfRobot + scene.num_free_shapes() + num_early_pairs(scene),
                  static_cast<int>(scene.shape_pairs().size()));
}

PairSearch::PairSearch(const CollisionScene& scene)
    : scene_(scene), shape_frames_(scene.shapes().size()), posed_(scene.shapes().size()) {
  for (const CollisionShape& shape : scene.shapes()) {
    turned_.push_back(shape.frame.axes.isIdentity(0) ? 0 : 1);
  }
  const auto most = at(max_near_pairs(scene));
  near_.reserve(most + 1);  // one that may be left out
  kept_.reserve(most);
  order_.reserve(most);
  moved_to_.reserve(most);
  added_.reserve(most);
}

void PairSearch::find(const BodyStates& bodies, const BroadPhase& broad_phase, int lane,
                      ContactMemory& memory, NarrowPhase& narrow_phase) {
  near_.clear();
  ++search_;
  const int known = static_cast<int>(memory.pairs.size());
  kept_.assign(memory.pairs.size(), 0);
  for (const NearShapes& candidate : broad_phase.near()) {
    if ((candidate.lanes >> lane & 1U) == 0) continue;
    const ShapePair& shapes = scene_.shape_pairs()[at(candidate.shape_pair)];
    const double travel = broad_phase.travel(lane, scene_.shapes()[at(shapes.a)].body) +
                          broad_phase.travel(lane, scene_.shapes()[at(shapes.b)].body);
    find_shape_pair(candidate.shape_pair, broad_phase.limits(candidate.shape_pair), travel, bodies,
                    memory, narrow_phase);
  }
  sort_new(known, memory);
  forget_distant(bodies, memory);
}

// Search until which the frame of a body stays what it is.
std::uint64_t PairSearch::known_until(int body) const {
  return scene_.bodies()[at(body)].kind == BodyKind::kStatic ? kForever : search_;
}

const Frame& PairSearch::shape_frame(int shape, const BodyStates& bodies) {
  Frame& frame = shape_frames_[at(shape)];
  if (posed_[at(shape)] < search_) {
    const CollisionShape& of = scene_.shapes()[at(shape)];
    posed_[at(shape)] = known_until(of.body);
    const Frame& body = bodies.frames[at(of.body)];
    frame.pos = body.pos + body.axes * of.frame.pos;
    frame.axes = body.axes;
    if (turned_[at(shape)] != 0) frame.axes = body.axes * of.frame.axes;
  }
  return frame;
}

void PairSearch::find_shape_pair(int index, const BroadPhaseLanes::ShapePair& limits, double travel,
                                 const BodyStates& bodies, ContactMemory& memory,
                                 NarrowPhase& narrow_phase) {
  const ShapePair& shapes = scene_.shape_pairs()[at(index)];
  const CollisionShape& a = scene_.shapes()[at(shapes.a)];
  const CollisionShape& b = scene_.shapes()[at(shapes.b)];
  const Frame& frame_a = shape_frame(shapes.a, bodies);
  const Frame& frame_b = shape_frame(shapes.b, bodies);
  const int known = record_of(index, memory);
  const double active = std::min(kActiveGap + travel, limits.max_reach);
  // Most new pairs have no point that can act: their separation costs less than points. The broad
  // phase tests that of boxes.
  const bool separable = known < 0 && !(a.is_box() && b.is_box());
  const double apart = separable ? narrow_phase.separation(index, frame_a, frame_b) : kUnknown;
  if (apart >= active) return;
  if (known < 0) {
    added_pair_.shape_pair = index;
    added_pair_.manifold = Manifold{};
  }
  ContactPair& pair = known < 0 ? added_pair_ : memory.pairs[at(known)];
  NearPair& near = near_.emplace_back(known, index, active + kLookAhead);
  // Fingers and balls out of reach need no points.
  const double to_ball =
      limits.near_gap > active ? gap_to_ball(a, frame_a, b, frame_b.pos) : kUnknown;
  if (to_ball >= active) {
    near.gap = to_ball;
  } else {
    near.points = narrow_phase.find(index, frame_a, frame_b, near.gap, pair);
  }
  for (const ContactPoint& point : near.points) near.gap = std::min(near.gap, point.gap);
  if (!(near.gap < std::max(active, limits.near_gap))) return near_.pop_back();
  near.points.keep_below(active);
  if (known < 0) {
    if (memory.pairs.size() == memory.pairs.capacity()) return near_.pop_back();
    near.record = static_cast<int>(memory.pairs.size());
    memory.pairs.push_back(added_pair_);
    kept_.push_back(0);
  }
  kept_[at(near.record)] = 1;
}

// Known pairs keep their order; new ones follow from the nearest on.
void PairSearch::sort_new(int known, ContactMemory& memory) {
  const auto rank = [](const NearPair& near) {
    return std::floor(near.gap * kOrderPrecision + 0.5);
  };
  order_.resize(near_.size());
  for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = static_cast<int>(i);
  std::sort(order_.begin(), order_.end(), [&](int first, int second) {
    const NearPair& a = near_[at(first)];
    const NearPair& b = near_[at(second)];
    if (a.record < known || b.record < known) return a.record < b.record;
    return rank(a) != rank(b) ? rank(a) < rank(b) : a.record < b.record;
  });
  if (at(known) == memory.pairs.size()) return;
  added_.assign(memory.pairs.begin() + known, memory.pairs.end());
  memory.pairs.resize(at(known));
  kept_.resize(at(known));
  for (const int i : order_) {
    NearPair& near = near_[at(i)];
    if (near.record < known) continue;
    const ContactPair& pair = added_[at(near.record - known)];
    near.record = static_cast<int>(memory.pairs.size());
    memory.pairs.push_back(pair);
    kept_.push_back(1);
  }
}

// Removes pairs that are no longer near; keeps those of sleeping props.
void PairSearch::forget_distant(const BodyStates& bodies, ContactMemory& memory) {
  const auto rests = [&](const ContactPair& pair) {
    const ShapePair& shapes = scene_.shape_pairs()[at(pair.shape_pair)];
    const BodyPresence a = bodies.presence[at(scene_.shapes()[at(shapes.a)].body)];
    const BodyPresence b = bodies.presence[at(scene_.shapes()[at(shapes.b)].body)];
    return a != BodyPresence::kAbsent && b != BodyPresence::kAbsent &&
           (a == BodyPresence::kResting || b == BodyPresence::kResting);
  };
  moved_to_.resize(memory.pairs.size());
  int next = 0;
  for (std::size_t i = 0; i < memory.pairs.size(); ++i) {
    const bool keep = kept_[i] != 0 || rests(memory.pairs[i]);
    if (!keep) continue;
    if (at(next) != i) memory.pairs[at(next)] = memory.pairs[i];
    moved_to_[i] = next++;
  }
  memory.pairs.resize(at(next));
  for (NearPair& near : near_) near.record = moved_to_[at(near.record)];
}

}  // namespace engram
