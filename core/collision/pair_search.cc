#include "core/collision/pair_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/index.h"
#include "core/scene/speculative_margin.h"

namespace engram {
namespace {

// Speculative contacts act before shapes touch. A point whose gap is larger than this and
// the displacement of the bodies in a substep does nothing: shapes with no nearer points are not
// near each other.
constexpr double kActiveGap = 0.0025;  // m
// Points up to so much farther are looked for, so that pairs without are not tested again soon.
// MuJoCo's convex collision is wrong for reaches of several centimetres.
constexpr double kLookAhead = 0.01;  // m
// What acceleration may add to a body's speed in a substep, besides kSpeculativeFactor.
constexpr double kSpeedGain = 0.15;  // m/s
// Bodies of the robot touch one another at no larger gap than this.
constexpr double kMaxSelfGap = 0.009;  // m
// Whatever a clearance calls clear is too far away for contacts.
static_assert(kMaxSelfGap < kSelfMargin);
static_assert(kActiveGap + kClearanceAllowance < kContactMargin);
// Pairs that come near in the same substep are solved from the nearest on, to this precision.
constexpr double kOrderPrecision = 1000;  // 1/m
// Pairs that are tested in every substep.
constexpr double kNever = -1;
// Bodies whose bounding spheres are so much farther apart than they can come together in a substep
// are not measured more precisely, m.
constexpr double kFarApart = 0.1;
// Substeps, as long as the present one, for which the pairs to visit are chosen.
constexpr double kVisitedSubsteps = 6;
// Factor beyond all rounding of sums of travel.
constexpr double kRoundingFactor = 1 + 1e-12;
constexpr std::uint64_t kForever = std::numeric_limits<std::uint64_t>::max();

// Lower bound of the distance of a point to a shape.
double distance_to(const CollisionShape& shape, const Frame& frame, const Vec3& point) {
  const Vec3 offset = point - frame.pos;
  if (shape.type != mjGEOM_BOX && shape.type != mjGEOM_PLANE) {
    return offset.norm() - shape.bounding_radius;
  }
  const Vec3 local = frame.axes.transpose() * offset;
  return (local - local.cwiseMin(shape.half).cwiseMax(-shape.half)).norm();
}

// Lower bound of the distance of two shapes, by spheres around them.
double min_distance_of(const CollisionShape& a, const Frame& frame_a, const CollisionShape& b,
                       const Frame& frame_b) {
  const double to_b = distance_to(b, frame_b, frame_a.pos) - a.bounding_radius;
  const double to_a = distance_to(a, frame_a, frame_b.pos) - b.bounding_radius;
  return std::max(to_a, to_b);
}

// Index of what is remembered of a pair of shapes, or -1.
int record_of(int shape_pair, const ContactMemory& memory) {
  const auto found = std::find_if(memory.pairs.begin(), memory.pairs.end(),
                                  [&](const ContactPair& p) { return p.shape_pair == shape_pair; });
  return found == memory.pairs.end() ? -1 : static_cast<int>(found - memory.pairs.begin());
}

// The original orders a ball's contacts with the fingers from where they may first exist. While a
// free ball is awake, no clearance leaves the search out.
double near_gap_of(const CollisionScene& scene, const ShapePair& pair) {
  const CollisionShape& a = scene.shapes()[at(pair.a)];
  const CollisionShape& b = scene.shapes()[at(pair.b)];
  const bool of_finger = finger_of(scene.bodies()[at(a.body)].link) >= 0;
  const bool of_ball =
      b.type == mjGEOM_SPHERE && scene.bodies()[at(b.body)].kind == BodyKind::kFree;
  return a.type == mjGEOM_BOX && of_finger && of_ball ? kContactReach : kActiveGap;
}

// Pairs that are remembered long before they can act.
int num_early_pairs(const CollisionScene& scene) {
  return static_cast<int>(std::ranges::count_if(scene.shape_pairs(), [&](const ShapePair& pair) {
    return near_gap_of(scene, pair) > kActiveGap;
  }));
}

bool moves_freely(const CollisionBody& body) {
  return body.kind == BodyKind::kLink || body.kind == BodyKind::kFree;
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
    : scene_(scene),
      travel_(scene.bodies().size()),
      bodies_clear_(scene.body_pairs().size()),
      visit_presence_(scene.bodies().size()),
      visit_travel_(scene.bodies().size()),
      shapes_clear_(scene.shape_pairs().size()),
      was_near_(scene.body_pairs().size()),
      shape_frames_(scene.shapes().size()),
      centers_(scene.bodies().size()),
      posed_(scene.shapes().size()),
      centered_(scene.bodies().size()) {
  for (const CollisionShape& shape : scene.shapes()) {
    turned_.push_back(shape.frame.axes.isIdentity(0) ? 0 : 1);
  }
  for (const ShapePair& pair : scene.shape_pairs()) near_gap_.push_back(near_gap_of(scene, pair));
  for (const BodyPair& pair : scene.body_pairs()) {
    const auto first = near_gap_.begin() + pair.first;
    bodies_near_gap_.push_back(*std::max_element(first, first + pair.count));
  }
  visits_.reserve(scene.body_pairs().size());
  const auto most = at(max_near_pairs(scene));
  near_.reserve(most + 1);  // one that may be left out
  kept_.reserve(most);
  order_.reserve(most);
  moved_to_.reserve(most);
  added_.reserve(most);
}

void PairSearch::begin() {
  std::fill(travel_.begin(), travel_.end(), Travel{});
  std::fill(bodies_clear_.begin(), bodies_clear_.end(), kNever);
  std::fill(was_near_.begin(), was_near_.end(), std::uint8_t{0});
  std::fill(visit_travel_.begin(), visit_travel_.end(), kNever);
}

void PairSearch::find(const BodyStates& bodies, ContactMemory& memory, NarrowPhase& narrow_phase,
                      double timestep) {
  near_.clear();
  advance_travel(bodies, timestep);
  ++search_;
  const int known = static_cast<int>(memory.pairs.size());
  kept_.assign(memory.pairs.size(), 0);
  if (visits_are_known(bodies)) {
    for (const int pair : visits_) find_body_pair(pair, bodies, memory, narrow_phase);
  } else {
    for (std::size_t i = 0; i < scene_.body_pairs().size(); ++i) {
      find_body_pair(static_cast<int>(i), bodies, memory, narrow_phase);
    }
    choose_visits(bodies);
  }
  sort_new(known, memory);
  forget_distant(bodies, memory);
}

void PairSearch::advance_travel(const BodyStates& bodies, double timestep) {
  for (std::size_t i = 0; i < travel_.size(); ++i) {
    const double gain = moves_freely(scene_.bodies()[i]) ? kSpeedGain : 0;
    travel_[i].before = travel_[i].after();
    travel_[i].substep = timestep * (kSpeculativeFactor * bodies.speeds[i] + gain);
  }
}

bool PairSearch::visits_are_known(const BodyStates& bodies) const {
  for (std::size_t i = 0; i < travel_.size(); ++i) {
    if (!(travel_[i].after() <= visit_travel_[i])) return false;
  }
  return bodies.presence == visit_presence_;
}

void PairSearch::choose_visits(const BodyStates& bodies) {
  visit_presence_ = bodies.presence;
  for (std::size_t i = 0; i < travel_.size(); ++i) {
    visit_travel_[i] = travel_[i].before + kVisitedSubsteps * travel_[i].substep;
  }
  visits_.clear();
  for (std::size_t i = 0; i < bodies_clear_.size(); ++i) {
    const BodyPair& pair = scene_.body_pairs()[i];
    if (visit_presence_[at(pair.a)] != BodyPresence::kPresent ||
        visit_presence_[at(pair.b)] != BodyPresence::kPresent) {
      continue;
    }
    const double most = visit_travel_[at(pair.a)] + visit_travel_[at(pair.b)];
    if (!(bodies_clear_[i] > kRoundingFactor * most)) visits_.push_back(static_cast<int>(i));
  }
}

PairSearch::Travel PairSearch::travel_of(int body_a, int body_b) const {
  const Travel& a = travel_[at(body_a)];
  const Travel& b = travel_[at(body_b)];
  return {a.before + b.before, a.substep + b.substep};
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

const Vec3& PairSearch::center(int body, const BodyStates& bodies) {
  Vec3& result = centers_[at(body)];
  if (centered_[at(body)] < search_) {
    centered_[at(body)] = known_until(body);
    const Frame& frame = bodies.frames[at(body)];
    result = frame.pos + frame.axes * scene_.bodies()[at(body)].bounding_center;
  }
  return result;
}

// Lower bound of the distance of A's centre to B, m: a rough one where it exceeds `needed` by far.
double PairSearch::body_distance(const BodyPair& pair, double needed, const BodyStates& bodies) {
  const Vec3& center_a = center(pair.a, bodies);
  const CollisionBody& b = scene_.bodies()[at(pair.b)];
  const double distance = (center_a - center(pair.b, bodies)).norm() - b.bounding_radius;
  if (b.num_shapes > 1 || distance > needed + kFarApart) return distance;
  return distance_to(scene_.shapes()[at(b.first_shape)], shape_frame(b.first_shape, bodies),
                     center_a);
}

void PairSearch::find_body_pair(int index, const BodyStates& bodies, ContactMemory& memory,
                                NarrowPhase& narrow_phase) {
  const BodyPair& pair = scene_.body_pairs()[at(index)];
  if (bodies.presence[at(pair.a)] != BodyPresence::kPresent ||
      bodies.presence[at(pair.b)] != BodyPresence::kPresent) {
    return;
  }
  const Travel travel = travel_of(pair.a, pair.b);
  if (travel.after() < bodies_clear_[at(index)]) return;
  const double around = scene_.bodies()[at(pair.a)].bounding_radius + bodies_near_gap_[at(index)];
  const double distance = body_distance(pair, around + travel.substep, bodies);
  bodies_clear_[at(index)] = travel.before + distance - around;
  if (travel.after() < bodies_clear_[at(index)]) return;
  if (was_near_[at(index)] == 0) {
    was_near_[at(index)] = 1;
    std::fill_n(shapes_clear_.begin() + pair.first, pair.count, kNever);
  }
  for (int i = pair.first; i < pair.first + pair.count; ++i) {
    if (travel.after() >= shapes_clear_[at(i)]) {
      find_shape_pair(i, travel, bodies, memory, narrow_phase);
    }
  }
}

void PairSearch::find_shape_pair(int index, const Travel& travel, const BodyStates& bodies,
                                 ContactMemory& memory, NarrowPhase& narrow_phase) {
  const ShapePair& shapes = scene_.shape_pairs()[at(index)];
  const CollisionShape& a = scene_.shapes()[at(shapes.a)];
  const CollisionShape& b = scene_.shapes()[at(shapes.b)];
  const Frame& frame_a = shape_frame(shapes.a, bodies);
  const Frame& frame_b = shape_frame(shapes.b, bodies);
  double& clear = shapes_clear_[at(index)];
  const double near_gap = near_gap_[at(index)];
  const double distance = min_distance_of(a, frame_a, b, frame_b);
  clear = travel.before + distance - near_gap;
  if (travel.after() < clear) return;
  clear = kNever;
  const int known = record_of(index, memory);
  const bool of_robot =
      scene_.bodies()[at(a.body)].of_robot && scene_.bodies()[at(b.body)].of_robot;
  const double reach = kActiveGap + travel.substep;
  const double active = of_robot ? std::min(reach, kMaxSelfGap) : reach;
  // Most new pairs have no point that can act: their separation costs less than points.
  const double apart = known < 0 ? narrow_phase.separation(index, frame_a, frame_b) : kNever;
  if (apart >= active) {
    clear = travel.before - near_gap + apart;
    return;
  }
  if (known < 0) {
    added_pair_.shape_pair = index;
    added_pair_.manifold = Manifold{};
  }
  ContactPair& pair = known < 0 ? added_pair_ : memory.pairs[at(known)];
  NearPair& near = near_.emplace_back(known, index, active + kLookAhead);
  // The distance of a finger and a ball is their gap: those out of reach need no points.
  const bool early = near_gap > active && distance >= active;
  if (early) {
    near.gap = distance;
  } else {
    near.points = narrow_phase.find(index, frame_a, frame_b, near.gap, pair);
  }
  for (const ContactPoint& point : near.points) near.gap = std::min(near.gap, point.gap);
  if (!(near.gap < std::max(active, near_gap))) {
    clear = travel.before - near_gap + narrow_phase.min_distance(index, frame_a, frame_b, near.gap);
    near_.pop_back();
    return;
  }
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
