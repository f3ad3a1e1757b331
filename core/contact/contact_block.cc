#include "core/contact/contact_block.h"

#include <algorithm>
#include <cstddef>

#include "core/base/index.h"

namespace engram {
namespace {

using Body = FreeBodyLanes<float>;
using Patch = PatchLanes<float>;
using Constraint = ConstraintLanes<float>;

// Row of a member in the layout.
#define ENGRAM_VECTOR(Type, member) static_cast<int>(offsetof(Type, member) / sizeof(float))

// Numbers of a patch that are set for each lane come first.
constexpr int kSetVectors = ENGRAM_VECTOR(Patch, slipping);

// Most patches of a lane in each list.
constexpr int kMaxMoving = 32;
constexpr int kMaxOfLink = 3;
constexpr int kMaxOfHand = 8;
constexpr int kMaxOfFinger = 6;
constexpr int kHandJoint = kArmJoints - 1;  // the last that moves the hand

// Two links of the robot count as no deeper in one another, m: the arm has no room to give way, and
// larger corrections would throw it through itself.
constexpr double kMaxSelfOverlap = 0.004;

// Joints that move a link of the robot (-1: none), as bits.
int joints_of(int link) {
  if (link < 0) return 0;
  const int finger = finger_of(link);
  return ((1 << hinges_of(link)) - 1) | (finger >= 0 ? 1 << (kArmJoints + finger) : 0);
}

int max_of_list(int list, int max_shapes) {
  if (list == PatchLists::kMoving) return kMaxMoving;
  if (list == PatchLists::kFixed) return 8 + 2 * max_shapes;
  const int joint = list - PatchLists::kLinks;
  return joint < kHandJoint ? kMaxOfLink : joint == kHandJoint ? kMaxOfHand : kMaxOfFinger;
}

class MutableLane {
 public:
  MutableLane(float* vectors, int lanes, int lane) : vectors_(vectors + lane), lanes_(lanes) {}
  void put(int index, double value) {
    // Nothing is a negative zero, so that adding a zero impulse never changes a bit.
    vectors_[static_cast<std::ptrdiff_t>(index) * lanes_] = static_cast<float>(value) + 0.0F;
  }
  void put(int index, const Vec3& value) {
    for (int k = 0; k < 3; ++k) put(index + k, value[k]);
  }

 private:
  float* vectors_;
  int lanes_;
};

class ConstLane {
 public:
  ConstLane(const float* vectors, int lanes, int lane) : vectors_(vectors + lane), lanes_(lanes) {}
  double operator[](int index) const {
    return vectors_[static_cast<std::ptrdiff_t>(index) * lanes_];
  }
  Vec3 vec3(int index) const { return {(*this)[index], (*this)[index + 1], (*this)[index + 2]}; }

 private:
  const float* vectors_;
  int lanes_;
};

}  // namespace

ContactBlock::ContactBlock(int lanes, int max_bodies, int max_shapes, const Vec3& base_position)
    : lanes_(lanes),
      base_(base_position),
      body_stride_(static_cast<std::ptrdiff_t>(sizeof(Body) / sizeof(float)) * lanes),
      patch_stride_(static_cast<std::ptrdiff_t>(sizeof(Patch) / sizeof(float)) * lanes) {
  int total = 0;
  for (int list = 0; list < PatchLists::kCount; ++list) {
    capacity_[at(list)] = max_of_list(list, max_shapes);
    view_.lists.begin[list] = total;
    total += capacity_[at(list)];
  }
  const auto vectors = [](int count, std::ptrdiff_t stride) {
    return AlignedArray<float>::uninitialized(at(count) * static_cast<std::size_t>(stride));
  };
  bodies_ = vectors(max_bodies, body_stride_);
  patches_ = vectors(total, patch_stride_);
  members_.resize(at(total));
  first_bodies_.resize(at(total));
  used_.resize(at(lanes));
  view_.bodies = bodies_.data();
  view_.patches = patches_.data();
  view_.members = members_.data();
}

void ContactBlock::clear() {
  for (int list = 0; list < PatchLists::kCount; ++list) {
    const int begin = view_.lists.begin[list];
    std::fill_n(members_.begin() + begin, view_.lists.size[list], PatchMembers{});
    view_.lists.size[list] = 0;
  }
  view_.num_bodies = 0;
  std::fill(used_.begin(), used_.end(), std::array<int, PatchLists::kCount>{});
}

void ContactBlock::put_body(int lane, int body_index, const FreeBody& body,
                            const FreeBodyState& state) {
  for (; view_.num_bodies <= body_index; ++view_.num_bodies) empty_body(view_.num_bodies);
  MutableLane vectors(body_vectors(body_index), lanes_, lane);
  const Mat3 inverse = body.inv_inertia(state.quat);
  const double tensor[6] = {inverse(0, 0), inverse(1, 1), inverse(2, 2),
                            inverse(0, 1), inverse(0, 2), inverse(1, 2)};
  vectors.put(ENGRAM_VECTOR(Body, inv_mass), body.inv_mass());
  for (int k = 0; k < 6; ++k) vectors.put(ENGRAM_VECTOR(Body, inv_inertia) + k, tensor[k]);
  vectors.put(ENGRAM_VECTOR(Body, center), state.center - base_);
  vectors.put(ENGRAM_VECTOR(Body, linear), state.linear);
  vectors.put(ENGRAM_VECTOR(Body, angular), state.angular);
  vectors.put(ENGRAM_VECTOR(Body, begin_linear), state.linear);
}

// Zeros are what a lane without this body or patch has, and a body that has not moved.
void ContactBlock::empty_body(int body_index) {
  float* const vectors = body_vectors(body_index);
  std::fill_n(vectors, body_stride_, 0.0F);
  std::fill_n(vectors + ENGRAM_VECTOR(Body, rotation) * lanes_, lanes_, 1.0F);
}

void ContactBlock::empty_patch(int patch) {
  float* const vectors = patch_vectors(patch);
  std::fill_n(vectors, kSetVectors * lanes_, 0.0F);
  for (const int index : {ENGRAM_VECTOR(Patch, link_a), ENGRAM_VECTOR(Patch, link_b),
                          ENGRAM_VECTOR(Patch, prop_a), ENGRAM_VECTOR(Patch, prop_b)}) {
    std::fill_n(vectors + index * lanes_, lanes_, -1.0F);
  }
}

int ContactBlock::add_patch(int lane, const PatchSpec& spec) {
  int& size = used_[at(lane)][at(spec.list)];
  if (size == capacity_[at(spec.list)]) return -1;
  const int patch = view_.lists.begin[spec.list] + size++;
  if (view_.lists.size[spec.list] < size) {
    view_.lists.size[spec.list] = size;
    empty_patch(patch);
  }
  MutableLane vectors(patch_vectors(patch), lanes_, lane);
  vectors.put(ENGRAM_VECTOR(Patch, link_a), spec.link_a);
  vectors.put(ENGRAM_VECTOR(Patch, link_b), spec.link_b);
  vectors.put(ENGRAM_VECTOR(Patch, prop_a), spec.body_a);
  vectors.put(ENGRAM_VECTOR(Patch, prop_b), spec.body_b);
  const int moves_a = joints_of(spec.link_a);
  const int moves_b = joints_of(spec.link_b);
  for (int i = 0; i < kRobotJoints; ++i) {
    vectors.put(ENGRAM_VECTOR(Patch, joint_sign) + i, (moves_a >> i & 1) - (moves_b >> i & 1));
  }
  vectors.put(ENGRAM_VECTOR(Patch, num_points), spec.num_points);
  vectors.put(ENGRAM_VECTOR(Patch, num_anchors), spec.num_anchors);
  vectors.put(ENGRAM_VECTOR(Patch, friction), spec.friction);
  vectors.put(ENGRAM_VECTOR(Patch, torsion_radius), spec.torsion_radius);
  vectors.put(ENGRAM_VECTOR(Patch, normal), spec.normal);
  vectors.put(ENGRAM_VECTOR(Patch, kinematic_velocity), spec.kinematic_velocity);
  for (int i = 0; i < spec.num_points; ++i) {
    const double gap = spec.gaps[at(i)];
    vectors.put(ENGRAM_VECTOR(Patch, point) + 3 * i, Vec3(spec.points[at(i)] - base_));
    vectors.put(ENGRAM_VECTOR(Patch, gap) + i,
                spec.link_b >= 0 ? std::max(gap, -kMaxSelfOverlap) : gap);
  }
  for (int i = 0; i < spec.num_anchors; ++i) {
    vectors.put(ENGRAM_VECTOR(Patch, anchor_a) + 3 * i, Vec3(spec.anchors_a[at(i)] - base_));
    vectors.put(ENGRAM_VECTOR(Patch, apart) + 3 * i,
                Vec3(spec.anchors_a[at(i)] - spec.anchors_b[at(i)]));
  }
  add_member(patch, spec);
  return patch;
}

void ContactBlock::add_member(int patch, const PatchSpec& spec) {
  PatchMembers& members = members_[at(patch)];
  std::array<int, 2>& first = first_bodies_[at(patch)];
  const bool is_first = members.num_points == 0;
  if (is_first) first = {spec.body_a, spec.body_b};
  members.mixed_links =
      members.mixed_links || (!is_first && (members.links != 0) != (spec.link_a >= 0));
  members.mixed_a = members.mixed_a || spec.body_a != first[0];
  members.mixed_b = members.mixed_b || spec.body_b != first[1];
  if (spec.body_a >= 0) members.props_a |= 1ULL << static_cast<unsigned>(spec.body_a);
  if (spec.body_b >= 0) members.props_b |= 1ULL << static_cast<unsigned>(spec.body_b);
  for (const int link : {spec.link_a, spec.link_b}) {
    if (link >= 0) members.links |= 1U << static_cast<unsigned>(link);
  }
  members.num_points = std::max(members.num_points, spec.num_points);
  members.num_anchors = std::max(members.num_anchors, spec.num_anchors);
  members.torsion = members.torsion || (spec.torsion_radius > 0 && spec.num_anchors == 1);
}

void ContactBlock::get_body(int lane, int body_index, FreeBodyState& state) const {
  const ConstLane vectors(body_vectors(body_index), lanes_, lane);
  state.center += vectors.vec3(ENGRAM_VECTOR(Body, delta_position));
  const int q = ENGRAM_VECTOR(Body, rotation);
  const Quat rotation(vectors[q], vectors[q + 1], vectors[q + 2], vectors[q + 3]);
  state.quat = (rotation * state.quat).normalized();
  state.linear = vectors.vec3(ENGRAM_VECTOR(Body, linear));
  state.angular = vectors.vec3(ENGRAM_VECTOR(Body, angular));
}

bool ContactBlock::is_slipping(int lane, int patch) const {
  return ConstLane(patch_vectors(patch), lanes_, lane)[ENGRAM_VECTOR(Patch, slipping)] > 0;
}

Vec3 ContactBlock::impulse(int lane, int patch) const {
  const ConstLane vectors(patch_vectors(patch), lanes_, lane);
  constexpr int kConstraintSize = static_cast<int>(sizeof(Constraint) / sizeof(float));
  const int impulse = ENGRAM_VECTOR(Constraint, impulse);
  double normal_impulse = 0;
  const auto points = static_cast<int>(vectors[ENGRAM_VECTOR(Patch, num_points)]);
  for (int i = 0; i < points; ++i) {
    normal_impulse +=
        vectors[ENGRAM_VECTOR(Patch, normal_constraint) + i * kConstraintSize + impulse];
  }
  Vec3 sum = normal_impulse * vectors.vec3(ENGRAM_VECTOR(Patch, normal));
  const auto anchors = static_cast<int>(vectors[ENGRAM_VECTOR(Patch, num_anchors)]);
  for (int i = 0; i < anchors; ++i) {
    for (int k = 0; k < 2; ++k) {
      const int index = ENGRAM_VECTOR(Patch, friction_constraint) + (2 * i + k) * kConstraintSize;
      sum += vectors[index + impulse] * vectors.vec3(ENGRAM_VECTOR(Patch, tangent) + 3 * k);
    }
  }
  return sum;
}

#undef ENGRAM_VECTOR

}  // namespace engram
