#include "core/collision/contact_pair.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>

namespace engram {
namespace {

constexpr int kShapePairs = 10;

struct Stored {
  std::array<std::int32_t, StoredPair::kInts> ids{};
  std::array<float, StoredPair::kFloats> values{};
};

Vec3 vec(double first) { return {first, first + 0.25, first + 0.5}; }

// A pair all of whose numbers differ, each exact in a float.
ContactPair busy_pair() {
  ContactPair pair;
  pair.shape_pair = 7;
  pair.manifold.known = true;
  pair.manifold.normal = vec(1);
  pair.manifold.position = vec(2);
  pair.manifold.quat_a = {3, 3.125, 3.25, 3.375};
  pair.manifold.quat_b = {4, 4.125, 4.25, 4.375};
  pair.manifold.num_points = 3;
  double next = 10;
  for (ManifoldPoint& point : pair.manifold.points) point = {vec(next++), vec(next++)};
  pair.num_patches = 2;
  for (FrictionPatch& patch : pair.patches) {
    patch.normal_a = vec(next++);
    patch.normal_b = vec(next++);
    for (FrictionAnchor& anchor : patch.anchors) anchor = {vec(next++), vec(next++)};
  }
  pair.patches[0].num_anchors = 2;
  pair.patches[1].num_anchors = 1;
  return pair;
}

Stored store(const ContactPair& pair, int prop_a, int prop_b) {
  Stored stored;
  store_pair(pair, prop_a, prop_b, stored.ids.data(), stored.values.data());
  return stored;
}

TEST_CASE("A stored pair comes back with all that it remembers", "[contact]") {
  const ContactPair pair = busy_pair();
  const Stored stored = store(pair, 2, -1);
  ContactPair loaded;
  REQUIRE(load_pair(stored.ids.data(), stored.values.data(), kShapePairs, loaded));
  CHECK(loaded.shape_pair == 7);
  CHECK(loaded.manifold.known);
  CHECK(loaded.manifold.num_points == 3);
  CHECK(loaded.manifold.normal == pair.manifold.normal);
  CHECK(loaded.manifold.position == pair.manifold.position);
  CHECK(loaded.manifold.quat_a == pair.manifold.quat_a);
  CHECK(loaded.manifold.quat_b == pair.manifold.quat_b);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(loaded.manifold.points[i].a == pair.manifold.points[i].a);
    CHECK(loaded.manifold.points[i].b == pair.manifold.points[i].b);
  }
  REQUIRE(loaded.num_patches == 2);
  for (std::size_t i = 0; i < ContactPair::kMaxPatches; ++i) {
    CHECK(loaded.patches[i].num_anchors == pair.patches[i].num_anchors);
    CHECK(loaded.patches[i].normal_a == pair.patches[i].normal_a);
    CHECK(loaded.patches[i].normal_b == pair.patches[i].normal_b);
    for (std::size_t k = 0; k < (i == 0 ? 2 : 1); ++k) {
      CHECK(loaded.patches[i].anchors[k].a == pair.patches[i].anchors[k].a);
      CHECK(loaded.patches[i].anchors[k].b == pair.patches[i].anchors[k].b);
    }
  }
}

TEST_CASE("A manifold without points is not one that is unknown", "[contact]") {
  ContactPair pair;
  pair.shape_pair = 0;
  for (const bool known : {false, true}) {
    pair.manifold.known = known;
    const Stored stored = store(pair, -1, -1);
    ContactPair loaded = busy_pair();
    REQUIRE(load_pair(stored.ids.data(), stored.values.data(), kShapePairs, loaded));
    CHECK(loaded.manifold.known == known);
    CHECK(loaded.manifold.num_points == 0);
    CHECK(loaded.num_patches == 0);
  }
}

TEST_CASE("A stored pair says which props it holds, and forgets on demand", "[contact]") {
  Stored stored = store(busy_pair(), 2, 0);
  CHECK(StoredPair::holds_prop(stored.ids.data(), 2));
  CHECK(StoredPair::holds_prop(stored.ids.data(), 0));
  CHECK_FALSE(StoredPair::holds_prop(stored.ids.data(), 1));
  const Stored without_prop = store(busy_pair(), -1, -1);
  for (int prop = 0; prop < 3; ++prop) {
    CHECK_FALSE(StoredPair::holds_prop(without_prop.ids.data(), prop));
  }

  StoredPair::forget(stored.ids.data());
  CHECK_FALSE(StoredPair::is_empty(stored.ids.data()));  // keeps its place in the order of solving
  ContactPair loaded;
  REQUIRE(load_pair(stored.ids.data(), stored.values.data(), kShapePairs, loaded));
  CHECK(loaded.shape_pair == 7);
  CHECK_FALSE(loaded.manifold.known);
  CHECK(loaded.num_patches == 0);
}

TEST_CASE("Numbers that no pair has are refused", "[contact]") {
  const auto loads = [](int id, int value) {
    Stored stored = store(busy_pair(), 2, -1);
    stored.ids[static_cast<std::size_t>(id)] = value;
    ContactPair pair;
    return load_pair(stored.ids.data(), stored.values.data(), kShapePairs, pair);
  };
  CHECK(loads(StoredPair::kShapePair, 1));
  CHECK(loads(StoredPair::kShapePair, kShapePairs));
  CHECK_FALSE(loads(StoredPair::kShapePair, 0));  // an empty place
  CHECK_FALSE(loads(StoredPair::kShapePair, -1));
  CHECK_FALSE(loads(StoredPair::kShapePair, kShapePairs + 1));
  CHECK(loads(StoredPair::kPoints, Manifold::kMaxPoints + 1));
  CHECK_FALSE(loads(StoredPair::kPoints, Manifold::kMaxPoints + 2));
  CHECK_FALSE(loads(StoredPair::kPoints, -1));
  CHECK_FALSE(loads(StoredPair::kPatches, ContactPair::kMaxPatches + 1));
  CHECK_FALSE(loads(StoredPair::kPatches, -1));
  for (int patch = 0; patch < ContactPair::kMaxPatches; ++patch) {
    CHECK(loads(StoredPair::kAnchors + patch, FrictionPatch::kMaxAnchors));
    CHECK_FALSE(loads(StoredPair::kAnchors + patch, FrictionPatch::kMaxAnchors + 1));
    CHECK_FALSE(loads(StoredPair::kAnchors + patch, -1));
  }
  const Stored empty;
  CHECK(StoredPair::is_empty(empty.ids.data()));
}

}  // namespace
}  // namespace engram
