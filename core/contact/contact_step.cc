#include "core/contact/contact_step.h"

#include <algorithm>
#include <cmath>

#include "core/base/index.h"
#include "core/contact/friction_patch.h"

namespace engram {
namespace {

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

ContactStep::ContactStep(const CollisionScene& scene) : scene_(scene), search_(scene) {
  refs_.reserve(at(max_near_pairs(scene)) * ContactPair::kMaxPatches);
}

void ContactStep::find(const BodyStates& bodies, const BroadPhase& broad_phase,
                       ContactMemory& memory, NarrowPhase& narrow_phase, int lane,
                       ContactBlock& block) {
  refs_.clear();
  num_moving_ = num_fixed_ = 0;
  search_.find(bodies, broad_phase, lane, memory, narrow_phase);
  search_.for_each([&](const NearPair& near) { add_patches(near, bodies, memory, lane, block); });
}

void ContactStep::add_patches(const NearPair& near, const BodyStates& bodies, ContactMemory& memory,
                              int lane, ContactBlock& block) {
  ContactPair& pair = memory.pairs[at(near.record)];
  if (near.points.empty()) return pair.forget_anchors();
  const ShapePair& shapes = scene_.shape_pairs()[at(near.shape_pair)];
  const int a = scene_.shapes()[at(shapes.a)].body;
  const int b = scene_.shapes()[at(shapes.b)].body;
  const CollisionBody& body_a = scene_.bodies()[at(a)];
  const CollisionBody& body_b = scene_.bodies()[at(b)];
  std::array<PatchSpec, ContactPair::kMaxPatches> specs;
  const int count = build_patches(near.points, center_frame(body_a, bodies.frames[at(a)]),
                                  center_frame(body_b, bodies.frames[at(b)]), pair, specs);
  for (int i = 0; i < count; ++i) {
    PatchSpec& spec = specs[at(i)];
    spec.list = list_of(body_a, body_b);
    spec.link_a = body_a.link;
    spec.link_b = body_b.link;
    spec.body_a = bodies.body_indices[at(a)];
    spec.body_b = bodies.body_indices[at(b)];
    spec.friction = shapes.friction;
    spec.torsion_radius = shapes.torsion_radius;
    spec.kinematic_velocity = bodies.kinematic_velocities[at(b)];
    const int patch = block.add_patch(lane, spec);
    if (patch < 0) continue;
    refs_.push_back({patch, near.record, i, near.shape_pair});
    if (spec.list == PatchLists::kMoving) ++num_moving_;
    if (spec.list == PatchLists::kFixed) ++num_fixed_;
  }
}

void ContactStep::finish(ContactMemory& memory, int lane, const ContactBlock& block) const {
  // From the last on: dropping one moves only later ones.
  for (std::size_t i = refs_.size(); i-- > 0;) {
    const Ref& ref = refs_[i];
    if (!block.is_slipping(lane, ref.patch)) continue;
    ContactPair& pair = memory.pairs[at(ref.record)];
    std::copy(pair.patches.begin() + ref.index + 1, pair.patches.begin() + pair.num_patches,
              pair.patches.begin() + ref.index);
    --pair.num_patches;
  }
}

}  // namespace engram
