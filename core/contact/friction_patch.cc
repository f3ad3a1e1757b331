#include "core/contact/friction_patch.h"

#include <algorithm>
#include <cmath>

#include "core/base/index.h"

namespace engram {
namespace {

constexpr double kSameNormal = 0.999;        // cosine
constexpr double kMaxParting = 0.0025;       // m along the normal: anchors are dropped
constexpr double kFrictionGap = 0.004;       // m: a point with a smaller gap carries friction
constexpr double kMinSpacingSquared = 1e-8;  // m^2, between two anchors

// Points of one patch in the order in which they are solved.
struct Group {
  FrictionPatch patch;
  Vec3 normal = Vec3::Zero();  // world
  // Anchors of the patch, world.
  std::array<Vec3, FrictionPatch::kMaxAnchors> anchors_a;
  std::array<Vec3, FrictionPatch::kMaxAnchors> anchors_b;
  std::array<int, kPatchPoints> points{};
  int size = 0;
};
struct Groups {
  std::array<Group, ContactPair::kMaxPatches> at_index;
  int size = 0;
};

void place_anchor(int k, const FrictionAnchor& anchor, const Frame& a, const Frame& b,
                  Group& group) {
  group.anchors_a[at(k)] = a.pos + a.axes * anchor.a;
  group.anchors_b[at(k)] = b.pos + b.axes * anchor.b;
}

// Patches of the last substep that still hold.
void keep_patches(const ContactPair& pair, const Frame& a, const Frame& b, Groups& groups) {
  for (int i = 0; i < pair.num_patches; ++i) {
    const FrictionPatch& patch = pair.patches[at(i)];
    if (patch.num_anchors == 0) continue;
    const Vec3 normal = a.axes * patch.normal_a;
    if (normal.dot(b.axes * patch.normal_b) <= kSameNormal) continue;
    Group& group = groups.at_index[at(groups.size)];
    bool parted = false;
    for (int k = 0; k < patch.num_anchors; ++k) {
      place_anchor(k, patch.anchors[at(k)], a, b, group);
      const Vec3 apart = group.anchors_a[at(k)] - group.anchors_b[at(k)];
      parted = parted || std::abs(apart.dot(normal)) >= kMaxParting;
    }
    if (parted) continue;
    group.patch = patch;
    group.normal = normal;
    ++groups.size;
  }
}

// The first patch with this normal, or a new one; null if there are too many.
Group* group_with(const Vec3& normal, const Frame& a, const Frame& b, Groups& groups) {
  for (int i = 0; i < groups.size; ++i) {
    if (normal.dot(groups.at_index[at(i)].normal) >= kSameNormal) return &groups.at_index[at(i)];
  }
  if (groups.size == ContactPair::kMaxPatches) return nullptr;
  Group& added = groups.at_index[at(groups.size++)];
  added.patch.normal_a = a.axes.transpose() * normal;
  added.patch.normal_b = b.axes.transpose() * normal;
  added.normal = normal;
  return &added;
}

// Consecutive points of one normal come together, before those that are in the patch already.
void group_points(const ContactPoints& points, const Frame& a, const Frame& b, Groups& groups) {
  for (int begin = 0; begin < points.size();) {
    int end = begin + 1;
    while (end < points.size() && points[begin].normal.dot(points[end].normal) >= kSameNormal) {
      ++end;
    }
    Group* const group = group_with(points[begin].normal, a, b, groups);
    if (group != nullptr) {
      const int count = std::min(end - begin, kPatchPoints - group->size);
      std::copy_backward(group->points.begin(), group->points.begin() + group->size,
                         group->points.begin() + group->size + count);
      for (int i = 0; i < count; ++i) group->points[at(i)] = begin + i;
      group->size += count;
    }
    begin = end;
  }
}

// Drops two anchors that stand closer than half the diagonal of all points' box.
void drop_narrow_anchors(const ContactPoints& points, const Frame& a, Group& group) {
  FrictionPatch& patch = group.patch;
  if (patch.num_anchors < 2) return;
  Vec3 low = points[group.points[0]].pos;
  Vec3 high = low;
  for (int i = 1; i < group.size; ++i) {
    low = low.cwiseMin(points[group.points[at(i)]].pos);
    high = high.cwiseMax(points[group.points[at(i)]].pos);
  }
  const Vec3 apart = a.axes * (patch.anchors[0].a - patch.anchors[1].a);
  if (4 * apart.squaredNorm() < (high - low).squaredNorm()) patch.num_anchors = 0;
}

// Takes missing anchors from the points: the first, then the one that spreads them most.
void grow_anchors(const ContactPoints& points, const Frame& a, const Frame& b, Group& group) {
  FrictionPatch& patch = group.patch;
  const int kept = patch.num_anchors;
  if (kept == FrictionPatch::kMaxAnchors) return;
  std::array<Vec3, FrictionPatch::kMaxAnchors> world;
  for (int i = 0; i < kept; ++i) world[at(i)] = group.anchors_a[at(i)];
  int count = kept;
  double spread = 0;
  for (int i = 0; i < group.size; ++i) {
    const ContactPoint& point = points[group.points[at(i)]];
    if (point.gap >= kFrictionGap) continue;
    if (count == 0) {
      world[0] = point.pos;
      count = 1;
    } else if (count == 1) {
      spread = (point.pos - world[0]).squaredNorm();
      if (spread > kMinSpacingSquared) world[at(count++)] = point.pos;
    } else {
      const double first = (point.pos - world[0]).squaredNorm();
      const double second = (point.pos - world[1]).squaredNorm();
      if (first > second && first > spread) {
        world[1] = point.pos;
        spread = first;
      } else if (first <= second && second > spread) {
        world[0] = point.pos;
        spread = second;
      }
    }
  }
  for (int i = kept; i < count; ++i) {
    patch.anchors[at(i)] = {a.axes.transpose() * (world[at(i)] - a.pos),
                            b.axes.transpose() * (world[at(i)] - b.pos)};
    place_anchor(i, patch.anchors[at(i)], a, b, group);
  }
  patch.num_anchors = count;
}

void fill_spec(const ContactPoints& points, const Group& group, PatchSpec& spec) {
  spec.normal = points[group.points[0]].normal;
  spec.num_points = group.size;
  for (int i = 0; i < group.size; ++i) {
    const ContactPoint& point = points[group.points[at(i)]];
    spec.points[at(i)] = point.pos;
    spec.gaps[at(i)] = point.gap;
  }
  spec.num_anchors = group.patch.num_anchors;
  for (int i = 0; i < spec.num_anchors; ++i) {
    spec.anchors_a[at(i)] = group.anchors_a[at(i)];
    spec.anchors_b[at(i)] = group.anchors_b[at(i)];
  }
}

}  // namespace

int build_patches(const ContactPoints& points, const Frame& a, const Frame& b, ContactPair& pair,
                  std::array<PatchSpec, ContactPair::kMaxPatches>& specs) {
  Groups groups;
  keep_patches(pair, a, b, groups);
  group_points(points, a, b, groups);
  pair.num_patches = 0;
  for (int i = 0; i < groups.size; ++i) {
    Group& group = groups.at_index[at(i)];
    if (group.size == 0) continue;
    drop_narrow_anchors(points, a, group);
    grow_anchors(points, a, b, group);
    fill_spec(points, group, specs[at(pair.num_patches)]);
    pair.patches[at(pair.num_patches++)] = group.patch;
  }
  return pair.num_patches;
}

}  // namespace engram
