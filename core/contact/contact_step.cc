#include "core/contact/contact_step.h"

#include <algorithm>
#include <cmath>

#include "core/base/index.h"
#include "core/contact/friction_patch.h"

namespace engram {
namespace {

// Shapes whose bounds are farther apart are not compared.
constexpr double kNearGap = kContactReach;
// A point whose gap is larger than this and the way that the bodies may approach in a substep does
// nothing: its row is left out.
constexpr double kRowGap = 0.004;      // m
constexpr double kLinkRowGap = 0.005;  // a finger starts within a substep
constexpr double kApproach = 1.5;      // of the present speeds
// Pairs that come near in the same substep are solved from the nearest on, to this precision.
constexpr double kOrderPrecision = 1000;  // 1/m

// Lower bound of the distance of a point to a shape.
double distance_to(const CollisionShape& shape, const Frame& frame, const Vec3& point) {
  const Vec3 offset = point - frame.pos;
  if (shape.type != mjGEOM_BOX && shape.type != mjGEOM_PLANE) {
    return offset.norm() - shape.bounding_radius;
  }
  const Vec3 local = frame.axes.transpose() * offset;
  return (local - local.cwiseMin(shape.half).cwiseMax(-shape.half)).norm();
}

Frame within(const Frame& outer, const Frame& inner) {
  return {outer.pos + outer.axes * inner.pos, outer.axes * inner.axes};
}

// Both spheres around the shapes come near the other shape.
bool shapes_near(const CollisionShape& a, const Frame& frame_a, const CollisionShape& b,
                 const Frame& frame_b) {
  return distance_to(b, frame_b, frame_a.pos) <= a.bounding_radius + kNearGap &&
         distance_to(a, frame_a, frame_b.pos) <= b.bounding_radius + kNearGap;
}

bool bodies_near(const CollisionScene& scene, const CollisionBody& a, const Frame& frame_a,
                 const CollisionBody& b, const Frame& frame_b) {
  const Vec3 center = frame_a.pos + frame_a.axes * a.bounding_center;
  const double reach = a.bounding_radius + kNearGap;
  if (b.num_shapes == 1) {
    const CollisionShape& shape = scene.shapes()[at(b.first_shape)];
    return distance_to(shape, within(frame_b, shape.frame), center) <= reach;
  }
  const Vec3 other = frame_b.pos + frame_b.axes * b.bounding_center;
  return (center - other).norm() <= reach + b.bounding_radius;
}

int joint_of(int link) {
  const int finger = finger_of(link);
  return finger >= 0 ? kArmJoints + finger : hinges_of(link) - 1;
}

int list_of(const CollisionBody& a, const CollisionBody& b) {
  const bool moves = b.kind == BodyKind::kLink || b.kind == BodyKind::kFree;
  if (moves) return PatchLists::kMoving;
  return a.kind == BodyKind::kLink ? PatchLists::kLinks + joint_of(a.link) : PatchLists::kFixed;
}

Frame center_frame(const CollisionBody& body, const Frame& frame) {
  return {frame.pos + frame.axes * body.center, frame.axes};
}

}  // namespace

BodyStates::BodyStates(const CollisionScene& scene)
    : presence(scene.bodies().size(), BodyPresence::kPresent),
      frames(scene.bodies().size()),
      slots(scene.bodies().size(), -1),
      kinematic_velocities(scene.bodies().size(), Vec3::Zero()),
      speeds(scene.bodies().size(), 0) {
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i] = scene.bodies()[i].attachment.frame;  // of static ones
  }
}

int max_contact_pairs(const CollisionScene& scene) {
  int free_bodies = 0;
  for (const CollisionBody& body : scene.bodies()) free_bodies += body.kind == BodyKind::kFree;
  return 48;
}

ContactStep::ContactStep(const CollisionScene& scene) : scene_(scene) {
  const auto most = at(max_contact_pairs(scene));
  near_.reserve(most);
  refs_.reserve(most * ContactPair::kMostPatches);
  kept_.reserve(most);
  new_place_.reserve(most);
  added_.reserve(most);
}

void ContactStep::find(const BodyStates& bodies, ContactMemory& memory,
                       NarrowPhase& narrow_phase, double timestep, int lane,
                       ContactBlock& block) {
  refs_.clear();
  find_near(bodies, memory, narrow_phase);
  for (const Near& near : near_) add_patches(near, bodies, memory, timestep, lane, block);
}

void ContactStep::find_near(const BodyStates& bodies, ContactMemory& memory,
                            NarrowPhase& narrow_phase) {
  near_.clear();
  const int known = static_cast<int>(memory.pairs.size());
  kept_.assign(memory.pairs.size(), 0);
  for (const BodyPair& pair : scene_.body_pairs()) {
    find_body_pair(pair, bodies, memory, narrow_phase);
  }
  sort_new(known, memory);
  forget_distant(bodies, memory);
}

// Known pairs keep their order; new ones follow from the nearest on.
void ContactStep::sort_new(int known, ContactMemory& memory) {
  const auto rank = [](const Near& near) { return std::floor(near.gap * kOrderPrecision + 0.5); };
  std::sort(near_.begin(), near_.end(), [&](const Near& a, const Near& b) {
    if (a.record < known || b.record < known) return a.record < b.record;
    const double first = rank(a);
    const double second = rank(b);
    return first != second ? first < second : a.record < b.record;
  });
  added_.assign(memory.pairs.begin() + known, memory.pairs.end());
  int next = known;
  for (Near& near : near_) {
    if (near.record < known) continue;
    memory.pairs[at(next)] = added_[at(near.record - known)];
    near.record = next++;
  }
  memory.pairs.resize(at(next));
  kept_.resize(at(next));
  std::fill(kept_.begin() + known, kept_.end(), std::uint8_t{1});
}

void ContactStep::find_body_pair(const BodyPair& pair, const BodyStates& bodies,
                                 ContactMemory& memory, NarrowPhase& narrow_phase) {
  if (bodies.presence[at(pair.a)] != BodyPresence::kPresent ||
      bodies.presence[at(pair.b)] != BodyPresence::kPresent) {
    return;
  }
  const Frame& frame_a = bodies.frames[at(pair.a)];
  const Frame& frame_b = bodies.frames[at(pair.b)];
  if (!bodies_near(scene_, scene_.bodies()[at(pair.a)], frame_a, scene_.bodies()[at(pair.b)],
                   frame_b)) {
    return;
  }
  for (int i = pair.first; i < pair.first + pair.count; ++i) {
    const ShapePair& shapes = scene_.shape_pairs()[at(i)];
    const CollisionShape& a = scene_.shapes()[at(shapes.a)];
    const CollisionShape& b = scene_.shapes()[at(shapes.b)];
    const Frame at_a = within(frame_a, a.frame);
    const Frame at_b = within(frame_b, b.frame);
    if (!shapes_near(a, at_a, b, at_b)) continue;
    const auto found =
        std::find_if(memory.pairs.begin(), memory.pairs.end(), [&](const ContactPair& known) {
          return known.shape_a == shapes.a && known.shape_b == shapes.b;
        });
    Near near;
    near.record = static_cast<int>(found - memory.pairs.begin());
    near.shape_pair = i;
    if (found == memory.pairs.end()) {
      if (memory.pairs.size() == memory.pairs.capacity()) continue;
      ContactPair added;
      added.shape_a = shapes.a;
      added.shape_b = shapes.b;
      memory.pairs.push_back(added);
      kept_.push_back(0);
    }
    near.points = narrow_phase.find(i, at_a, at_b, memory.pairs[at(near.record)]);
    if (near.points.empty()) continue;
    near.gap = near.points[0].gap;
    for (const ContactPoint& point : near.points) near.gap = std::min(near.gap, point.gap);
    kept_[at(near.record)] = 1;
    near_.push_back(near);
  }
}

// Removes pairs that are no longer near; keeps those of sleeping props.
void ContactStep::forget_distant(const BodyStates& bodies, ContactMemory& memory) {
  const auto presence = [&](int shape) {
    return bodies.presence[at(scene_.shapes()[at(shape)].body)];
  };
  const auto rests = [&](const ContactPair& pair) {
    const BodyPresence a = presence(pair.shape_a);
    const BodyPresence b = presence(pair.shape_b);
    return a != BodyPresence::kAbsent && b != BodyPresence::kAbsent &&
           (a == BodyPresence::kResting || b == BodyPresence::kResting);
  };
  new_place_.assign(memory.pairs.size(), -1);
  int next = 0;
  for (std::size_t i = 0; i < memory.pairs.size(); ++i) {
    if (kept_[i] == 0 && !rests(memory.pairs[i])) continue;
    new_place_[i] = next;
    if (at(next) != i) memory.pairs[at(next)] = memory.pairs[i];
    ++next;
  }
  memory.pairs.resize(at(next));
  for (Near& near : near_) near.record = new_place_[at(near.record)];
}

void ContactStep::add_patches(const Near& near, const BodyStates& bodies, ContactMemory& memory,
                              double timestep, int lane, ContactBlock& block) {
  const ShapePair& shapes = scene_.shape_pairs()[at(near.shape_pair)];
  const int a = scene_.shapes()[at(shapes.a)].body;
  const int b = scene_.shapes()[at(shapes.b)].body;
  const CollisionBody& body_a = scene_.bodies()[at(a)];
  const CollisionBody& body_b = scene_.bodies()[at(b)];
  const bool with_link = body_a.kind == BodyKind::kLink;
  const double reach = (with_link ? kLinkRowGap : kRowGap) +
                       kApproach * timestep * (bodies.speeds[at(a)] + bodies.speeds[at(b)]);
  ContactPoints points;
  for (const ContactPoint& point : near.points) {
    if (point.gap < reach) points.push(point);
  }
  ContactPair& pair = memory.pairs[at(near.record)];
  std::array<PatchSpec, ContactPair::kMostPatches> specs;
  const int count = build_patches(points, center_frame(body_a, bodies.frames[at(a)]),
                                  center_frame(body_b, bodies.frames[at(b)]), pair, specs);
  for (int i = 0; i < count; ++i) {
    PatchSpec& spec = specs[at(i)];
    spec.list = list_of(body_a, body_b);
    spec.link_a = body_a.link;
    spec.link_b = body_b.link;
    spec.slot_a = bodies.slots[at(a)];
    spec.slot_b = bodies.slots[at(b)];
    spec.friction = shapes.friction;
    spec.torsion_radius = shapes.torsion_radius;
    spec.kinematic_velocity = bodies.kinematic_velocities[at(b)];
    const int patch = block.add_patch(lane, spec);
    if (patch >= 0) refs_.push_back({patch, near.record, i, shapes.a, shapes.b});
  }
}

void ContactStep::finish(ContactMemory& memory, int lane, const ContactBlock& block) const {
  // From the last on: dropping one moves only later ones.
  for (std::size_t i = refs_.size(); i-- > 0;) {
    const Ref& ref = refs_[i];
    if (!block.is_broken(lane, ref.patch)) continue;
    ContactPair& pair = memory.pairs[at(ref.record)];
    std::copy(pair.patches.begin() + ref.index + 1, pair.patches.begin() + pair.num_patches,
              pair.patches.begin() + ref.index);
    --pair.num_patches;
  }
}

}  // namespace engram
