#include "core/collision/contact_pair.h"

#include <algorithm>

#include "core/base/index.h"

namespace engram {
namespace {

// Visits the real numbers that a pair uses, with their places in the layout.
template <class Pair, class Visit>
void for_each_number(Pair& pair, const Visit& visit) {
  int place = 0;
  const auto all = [&](auto& vector, bool used) {
    for (int i = 0; used && i < vector.size(); ++i) visit(place + i, vector[i]);
    place += static_cast<int>(vector.size());
  };
  auto& manifold = pair.manifold;
  all(manifold.normal, manifold.known);
  all(manifold.position, manifold.known);
  all(manifold.quat_a, manifold.known);
  all(manifold.quat_b, manifold.known);
  for (int i = 0; i < Manifold::kMaxPoints; ++i) {
    auto& point = manifold.points[at(i)];
    const bool used = manifold.known && i < manifold.num_points;
    all(point.a, used);
    all(point.b, used);
  }
  for (int i = 0; i < ContactPair::kMaxPatches; ++i) {
    auto& patch = pair.patches[at(i)];
    const bool used = i < pair.num_patches;
    all(patch.normal_a, used);
    all(patch.normal_b, used);
    for (int k = 0; k < FrictionPatch::kMaxAnchors; ++k) {
      all(patch.anchors[at(k)].a, used && k < patch.num_anchors);
      all(patch.anchors[at(k)].b, used && k < patch.num_anchors);
    }
  }
}

}  // namespace

void store_pair(const ContactPair& pair, int prop_a, int prop_b, std::int32_t* ids, float* values) {
  ids[StoredPair::kShapePair] = pair.shape_pair + 1;
  ids[StoredPair::kPropA] = prop_a + 1;
  ids[StoredPair::kPropB] = prop_b + 1;
  ids[StoredPair::kPoints] = pair.manifold.known ? pair.manifold.num_points + 1 : 0;
  ids[StoredPair::kPatches] = pair.num_patches;
  for (int i = 0; i < ContactPair::kMaxPatches; ++i) {
    ids[StoredPair::kAnchors + i] = i < pair.num_patches ? pair.patches[at(i)].num_anchors : 0;
  }
  std::fill_n(values, StoredPair::kFloats, 0.0F);
  for_each_number(pair, [=](int i, double value) { values[i] = static_cast<float>(value); });
}

bool load_pair(const std::int32_t* ids, const float* values, int num_shape_pairs,
               ContactPair& pair) {
  const auto within = [ids](int id, int low, int high) {
    return low <= ids[id] && ids[id] <= high;
  };
  if (!within(StoredPair::kShapePair, 1, num_shape_pairs) ||
      !within(StoredPair::kPoints, 0, Manifold::kMaxPoints + 1) ||
      !within(StoredPair::kPatches, 0, ContactPair::kMaxPatches)) {
    return false;
  }
  pair.shape_pair = ids[StoredPair::kShapePair] - 1;
  pair.manifold.known = ids[StoredPair::kPoints] > 0;
  pair.manifold.num_points = std::max(ids[StoredPair::kPoints] - 1, 0);
  pair.num_patches = ids[StoredPair::kPatches];
  for (int i = 0; i < ContactPair::kMaxPatches; ++i) {
    if (!within(StoredPair::kAnchors + i, 0, FrictionPatch::kMaxAnchors)) return false;
    pair.patches[at(i)].num_anchors = ids[StoredPair::kAnchors + i];
  }
  for_each_number(pair, [=](int i, double& value) { value = values[i]; });
  return true;
}

}  // namespace engram
