// Memory of the contact solver for one block of lanes, filled and read lane by lane.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/base/aligned_array.h"
#include "core/collision/contact_pair.h"
#include "core/collision/contact_point.h"
#include "core/contact/contact_lanes.h"
#include "core/scene/free_body.h"

namespace engram {

// One patch as it is found: contacts of one pair with one normal.
struct PatchSpec {
  int list = 0;  // of PatchLists
  int link_a = -1;
  int link_b = -1;
  int body_a = -1;
  int body_b = -1;
  double friction = 0;
  double torsion_radius = 0;
  Vec3 normal = Vec3::Zero();              // from B to A
  Vec3 kinematic_velocity = Vec3::Zero();  // of B
  std::array<Vec3, kPatchPoints> points;   // world
  std::array<double, kPatchPoints> gaps{};
  int num_points = 0;
  std::array<Vec3, kPatchAnchors> anchors_a;  // world
  std::array<Vec3, kPatchAnchors> anchors_b;
  int num_anchors = 0;
};

class ContactBlock {
 public:
  // `max_bodies`: free bodies of an environment; `max_shapes`: theirs.
  ContactBlock(int lanes, int max_bodies, int max_shapes, const Vec3& base_position);

  int lanes() const { return lanes_; }

  // Begins a substep.
  void clear();
  void put_body(int lane, int body_index, const FreeBody& body, const FreeBodyState& state);
  // Appends a patch to its list. Returns its index, or -1 if the lane's list is full.
  int add_patch(int lane, const PatchSpec& spec);
  const ContactLanes& view() const { return view_; }

  // After the substep: the body's motion; what a patch has become.
  void get_body(int lane, int body_index, FreeBodyState& state) const;
  bool is_slipping(int lane, int patch) const;
  // Sum of impulses on A, N s, world.
  Vec3 impulse(int lane, int patch) const;

 private:
  float* body_vectors(int body_index) { return bodies_.data() + body_index * body_stride_; }
  const float* body_vectors(int body_index) const {
    return bodies_.data() + body_index * body_stride_;
  }
  float* patch_vectors(int patch) { return patches_.data() + patch * patch_stride_; }
  const float* patch_vectors(int patch) const { return patches_.data() + patch * patch_stride_; }
  void empty_patch(int patch);
  void empty_body(int body_index);
  void add_member(int patch, const PatchSpec& spec);

  int lanes_;
  Vec3 base_;
  std::ptrdiff_t body_stride_;
  std::ptrdiff_t patch_stride_;
  std::array<int, PatchLists::kCount> capacity_;
  AlignedArray<float> bodies_;
  AlignedArray<float> patches_;
  std::vector<PatchMembers> members_;
  // Slots of the lanes that a patch's members were collected from.
  std::vector<std::array<int, 2>> first_bodies_;
  std::vector<std::array<int, PatchLists::kCount>> used_;  // sizes of each lane's lists
  ContactLanes view_;
};

}  // namespace engram
