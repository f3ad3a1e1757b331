#include "core/collision/contact_pair.h"

#include <algorithm>

#include "core/base/index.h"

namespace engram {
namespace {

// Visits all real numbers of a pair in the order of their layout.
template <class Pair, class Visit>
void for_each_number(Pair& pair, const Visit& visit) {
  const auto all = [&](auto& vector) {
    for (int i = 0; i < vector.size(); ++i) visit(vector[i]);
  };
  all(pair.manifold.normal);
  all(pair.manifold.position);
  all(pair.manifold.quat_a);
  all(pair.manifold.quat_b);
  for (auto& point : pair.manifold.points) all(point.a), all(point.b);
  for (auto& patch : pair.patches) {
    all(patch.normal_a);
    all(patch.normal_b);
    for (auto& anchor : patch.anchors) all(anchor.a), all(anchor.b);
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
  for_each_number(pair, [&](double value) { *values++ = static_cast<float>(value); });
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
  for_each_number(pair, [&](double& value) { value = *values++; });
  return true;
}

}  // namespace engram
