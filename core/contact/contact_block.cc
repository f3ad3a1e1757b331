#include "core/contact/contact_block.h"

#include <algorithm>
#include <cstddef>

#include "core/base/index.h"

namespace engram {
namespace {

using Body = FreeBodyLanes<double>;
using Patch = PatchLanes<double>;
using Row = ContactRowLanes<double>;

// Row of a member in the layout.
#define ENGRAM_ROW(Type, member) static_cast<int>(offsetof(Type, member) / sizeof(double))

// Numbers of a patch that are set for each lane come first.
constexpr int kSetRows = ENGRAM_ROW(Patch, broken);

// Most patches of a lane in each list.
constexpr int kMostMoving = 32;
constexpr int kMostOfLink = 3;
constexpr int kMostOfHand = 8;
constexpr int kMostOfFinger = 6;

// Two links of the robot count as no deeper in one another, m: the arm has no room to give way, and
// larger corrections would throw it through itself.
constexpr double kMostSelfOverlap = 0.004;

int most_fixed(int max_shapes) { return 8 + 2 * max_shapes; }

// Joint after which contacts of a link with fixed bodies are solved.
int joint_of_list(int list) { return list - PatchLists::kLinks; }

class MutableLane {
 public:
  MutableLane(double* rows, int lanes, int lane) : rows_(rows + lane), lanes_(lanes) {}
  double& operator[](int row) { return rows_[static_cast<std::ptrdiff_t>(row) * lanes_]; }
  void put(int row, const Vec3& value) {
    for (int k = 0; k < 3; ++k) (*this)[row + k] = value[k];
  }

 private:
  double* rows_;
  int lanes_;
};

class ConstLane {
 public:
  ConstLane(const double* rows, int lanes, int lane) : rows_(rows + lane), lanes_(lanes) {}
  double operator[](int row) const { return rows_[static_cast<std::ptrdiff_t>(row) * lanes_]; }
  Vec3 vec3(int row) const { return {(*this)[row], (*this)[row + 1], (*this)[row + 2]}; }

 private:
  const double* rows_;
  int lanes_;
};

}  // namespace

ContactBlock::ContactBlock(int lanes, int max_bodies, int max_shapes, const Vec3& base_position)
    : lanes_(lanes),
      base_(base_position),
      body_stride_(static_cast<std::ptrdiff_t>(sizeof(Body) / sizeof(double)) * lanes),
      patch_stride_(static_cast<std::ptrdiff_t>(sizeof(Patch) / sizeof(double)) * lanes) {
  int total = 0;
  for (int list = 0; list < PatchLists::kCount; ++list) {
    int& capacity = capacity_[at(list)];
    if (list == PatchLists::kMoving) {
      capacity = kMostMoving;
    } else if (list == PatchLists::kFixed) {
      capacity = most_fixed(max_shapes);
    } else if (joint_of_list(list) < kArmJoints - 1) {
      capacity = kMostOfLink;
    } else {
      capacity = joint_of_list(list) == kArmJoints - 1 ? kMostOfHand : kMostOfFinger;
    }
    view_.lists.begin[list] = total;
    total += capacity;
  }
  const auto rows = [](int count, std::ptrdiff_t stride) {
    return AlignedArray<double>::uninitialized(at(count) * static_cast<std::size_t>(stride));
  };
  bodies_ = rows(max_bodies, body_stride_);
  patches_ = rows(total, patch_stride_);
  members_.resize(at(total));
  first_slots_.resize(at(total));
  used_.bodies.resize(at(lanes));
  used_.lists.resize(at(lanes));
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
  std::fill(used_.bodies.begin(), used_.bodies.end(), 0);
  std::fill(used_.lists.begin(), used_.lists.end(), std::array<int, PatchLists::kCount>{});
}

void ContactBlock::put_body(int lane, int slot, const FreeBody& body, const FreeBodyState& state) {
  MutableLane rows(body_row(slot), lanes_, lane);
  const Mat3 inverse = body.inv_inertia(state.quat);
  const double tensor[6] = {inverse(0, 0), inverse(1, 1), inverse(2, 2),
                            inverse(0, 1), inverse(0, 2), inverse(1, 2)};
  rows[ENGRAM_ROW(Body, inv_mass)] = body.inv_mass();
  for (int k = 0; k < 6; ++k) rows[ENGRAM_ROW(Body, inv_inertia) + k] = tensor[k];
  rows.put(ENGRAM_ROW(Body, center), state.center - base_);
  // No velocity is a negative zero, so that adding a zero impulse never changes a bit.
  const Vec3 linear = state.linear + Vec3::Zero();
  rows.put(ENGRAM_ROW(Body, linear), linear);
  rows.put(ENGRAM_ROW(Body, angular), state.angular + Vec3::Zero());
  rows.put(ENGRAM_ROW(Body, begin_linear), linear);
  rows.put(ENGRAM_ROW(Body, moved), Vec3::Zero());
  rows.put(ENGRAM_ROW(Body, turned), Vec3::Zero());
  const double identity[4] = {1, 0, 0, 0};
  for (int k = 0; k < 4; ++k) rows[ENGRAM_ROW(Body, rotation) + k] = identity[k];
  used_.bodies[at(lane)] = std::max(used_.bodies[at(lane)], slot + 1);
  view_.num_bodies = std::max(view_.num_bodies, slot + 1);
}

void ContactBlock::empty_body(int lane, int slot) {
  MutableLane rows(body_row(slot), lanes_, lane);
  for (std::size_t row = 0; row < sizeof(Body) / sizeof(double); ++row) {
    rows[static_cast<int>(row)] = 0;
  }
  rows[ENGRAM_ROW(Body, rotation)] = 1;
}

void ContactBlock::empty_patch(int lane, int patch) {
  MutableLane rows(patch_row(patch), lanes_, lane);
  for (int row = 0; row < kSetRows; ++row) rows[row] = 0;
  for (const int row : {ENGRAM_ROW(Patch, link_a), ENGRAM_ROW(Patch, link_b),
                        ENGRAM_ROW(Patch, prop_a), ENGRAM_ROW(Patch, prop_b)}) {
    rows[row] = -1;
  }
}

int ContactBlock::add_patch(int lane, const PatchSpec& spec) {
  int& size = used_.lists[at(lane)][at(spec.list)];
  if (size == capacity_[at(spec.list)]) return -1;
  const int patch = view_.lists.begin[spec.list] + size++;
  view_.lists.size[spec.list] = std::max(view_.lists.size[spec.list], size);
  empty_patch(lane, patch);
  MutableLane rows(patch_row(patch), lanes_, lane);
  rows[ENGRAM_ROW(Patch, link_a)] = spec.link_a;
  rows[ENGRAM_ROW(Patch, link_b)] = spec.link_b;
  rows[ENGRAM_ROW(Patch, prop_a)] = spec.slot_a;
  rows[ENGRAM_ROW(Patch, prop_b)] = spec.slot_b;
  for (const auto& [link, sign] : {std::pair(spec.link_a, 1.0), std::pair(spec.link_b, -1.0)}) {
    if (link < 0) continue;
    for (int i = 0; i < hinges_of(link); ++i) rows[ENGRAM_ROW(Patch, joint_sign) + i] += sign;
    const int finger = finger_of(link);
    if (finger >= 0) rows[ENGRAM_ROW(Patch, joint_sign) + kArmJoints + finger] += sign;
  }
  rows[ENGRAM_ROW(Patch, num_points)] = spec.num_points;
  rows[ENGRAM_ROW(Patch, num_anchors)] = spec.num_anchors;
  rows[ENGRAM_ROW(Patch, friction)] = spec.friction;
  rows[ENGRAM_ROW(Patch, torsion_radius)] = spec.torsion_radius;
  rows.put(ENGRAM_ROW(Patch, normal), spec.normal);
  rows.put(ENGRAM_ROW(Patch, kinematic_velocity), spec.kinematic_velocity);
  for (int i = 0; i < spec.num_points; ++i) {
    rows.put(ENGRAM_ROW(Patch, point) + 3 * i, spec.points[at(i)] - base_);
    const double gap = spec.gaps[at(i)];
    rows[ENGRAM_ROW(Patch, gap) + i] = spec.link_b >= 0 ? std::max(gap, -kMostSelfOverlap) : gap;
  }
  for (int i = 0; i < spec.num_anchors; ++i) {
    rows.put(ENGRAM_ROW(Patch, anchor_a) + 3 * i, spec.anchors_a[at(i)] - base_);
    rows.put(ENGRAM_ROW(Patch, anchor_b) + 3 * i, spec.anchors_b[at(i)] - base_);
  }
  add_member(lane, patch, spec);
  return patch;
}

void ContactBlock::add_member(int /*lane*/, int patch, const PatchSpec& spec) {
  PatchMembers& members = members_[at(patch)];
  std::array<int, 2>& first = first_slots_[at(patch)];
  const bool is_first = members.num_points == 0;
  if (is_first) first = {spec.slot_a, spec.slot_b};
  members.mixed_links =
      members.mixed_links || (!is_first && (members.links != 0) != (spec.link_a >= 0));
  members.mixed_a = members.mixed_a || spec.slot_a != first[0];
  members.mixed_b = members.mixed_b || spec.slot_b != first[1];
  if (spec.slot_a >= 0) members.props_a |= 1ULL << static_cast<unsigned>(spec.slot_a);
  if (spec.slot_b >= 0) members.props_b |= 1ULL << static_cast<unsigned>(spec.slot_b);
  for (const int link : {spec.link_a, spec.link_b}) {
    if (link >= 0) members.links |= 1U << static_cast<unsigned>(link);
  }
  members.num_points = std::max(members.num_points, spec.num_points);
  members.num_anchors = std::max(members.num_anchors, spec.num_anchors);
  members.torsion = members.torsion || (spec.torsion_radius > 0 && spec.num_anchors == 1);
}

const ContactLanes& ContactBlock::finish() {
  for (int lane = 0; lane < lanes_; ++lane) {
    for (int slot = used_.bodies[at(lane)]; slot < view_.num_bodies; ++slot) {
      empty_body(lane, slot);
    }
    for (int list = 0; list < PatchLists::kCount; ++list) {
      for (int i = used_.lists[at(lane)][at(list)]; i < view_.lists.size[list]; ++i) {
        empty_patch(lane, view_.lists.begin[list] + i);
      }
    }
  }
  return view_;
}

void ContactBlock::get_body(int lane, int slot, FreeBodyState& state) const {
  const ConstLane rows(body_row(slot), lanes_, lane);
  state.center += rows.vec3(ENGRAM_ROW(Body, moved));
  const int q = ENGRAM_ROW(Body, rotation);
  const Quat rotation(rows[q], rows[q + 1], rows[q + 2], rows[q + 3]);
  state.quat = (rotation * state.quat).normalized();
  state.linear = rows.vec3(ENGRAM_ROW(Body, linear));
  state.angular = rows.vec3(ENGRAM_ROW(Body, angular));
}

bool ContactBlock::is_broken(int lane, int patch) const {
  return ConstLane(patch_row(patch), lanes_, lane)[ENGRAM_ROW(Patch, broken)] > 0;
}

Vec3 ContactBlock::impulse(int lane, int patch) const {
  const ConstLane rows(patch_row(patch), lanes_, lane);
  constexpr int kRowSize = static_cast<int>(sizeof(Row) / sizeof(double));
  const int impulse = ENGRAM_ROW(Row, impulse);
  double load = 0;
  const auto points = static_cast<int>(rows[ENGRAM_ROW(Patch, num_points)]);
  for (int i = 0; i < points; ++i) {
    load += rows[ENGRAM_ROW(Patch, normal_row) + i * kRowSize + impulse];
  }
  Vec3 sum = load * rows.vec3(ENGRAM_ROW(Patch, normal));
  const auto anchors = static_cast<int>(rows[ENGRAM_ROW(Patch, num_anchors)]);
  for (int i = 0; i < anchors; ++i) {
    for (int k = 0; k < 2; ++k) {
      const int row = ENGRAM_ROW(Patch, friction_row) + (2 * i + k) * kRowSize;
      sum += rows[row + impulse] * rows.vec3(ENGRAM_ROW(Patch, tangent) + 3 * k);
    }
  }
  return sum;
}

#undef ENGRAM_ROW

}  // namespace engram
