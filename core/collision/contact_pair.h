// Memory of one pair of shapes: what the contact law keeps from substep to substep. A contact
// manifold's points persist until the shapes have moved enough; friction anchors persist until they
// slip.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/math/eigen_types.h"

namespace engram {

// Points of friction: where two bodies stick to one another, from each centre of mass, body axes.
struct FrictionAnchor {
  Vec3 a = Vec3::Zero();
  Vec3 b = Vec3::Zero();
};

// Contacts of one normal, and up to two anchors.
struct FrictionPatch {
  static constexpr int kMaxAnchors = 2;
  Vec3 normal_a = Vec3::Zero();  // in the axes of both bodies
  Vec3 normal_b = Vec3::Zero();
  std::array<FrictionAnchor, kMaxAnchors> anchors;
  int num_anchors = 0;
};

struct ManifoldPoint {
  Vec3 a = Vec3::Zero();  // on the surface of each shape, in its frame
  Vec3 b = Vec3::Zero();
};

struct Manifold {
  static constexpr int kMaxPoints = 4;
  bool known = false;            // found at the relative pose below
  Vec3 normal = Vec3::Zero();    // from B to A, in B's frame
  Vec3 position = Vec3::Zero();  // of A in B's frame
  Eigen::Vector4d quat_a = Eigen::Vector4d::Zero();
  Eigen::Vector4d quat_b = Eigen::Vector4d::Zero();
  std::array<ManifoldPoint, kMaxPoints> points;
  int num_points = 0;
};

struct ContactPair {
  static constexpr int kMaxPatches = 2;
  int shape_pair = -1;  // of the CollisionScene
  Manifold manifold;
  std::array<FrictionPatch, kMaxPatches> patches;
  int num_patches = 0;

  void forget_anchors() { num_patches = 0; }
};

// Layout of a pair in an environment's columns.
struct StoredPair {
  enum Id {
    kShapePair,  // plus one; 0: empty
    kPropA,      // of the task plus one; 0: none
    kPropB,
    kPoints,  // of the manifold, plus one; 0: unknown
    kPatches,
    kAnchors,  // of each patch
    kInts = kAnchors + ContactPair::kMaxPatches,
  };
  static constexpr int kFloats = 3 + 3 + 4 + 4 + 6 * Manifold::kMaxPoints +
                                 ContactPair::kMaxPatches * (6 + 6 * FrictionPatch::kMaxAnchors);

  static bool is_empty(const std::int32_t* ids) { return ids[kShapePair] == 0; }
  static bool holds_prop(const std::int32_t* ids, int prop) {
    return ids[kPropA] == prop + 1 || ids[kPropB] == prop + 1;
  }
  // Forgets points and anchors.
  static void forget(std::int32_t* ids) { ids[kPoints] = ids[kPatches] = 0; }
};

// Writes a pair of these props of the task (-1: none); reads one, false for numbers that no pair
// has.
void store_pair(const ContactPair& pair, int prop_a, int prop_b, std::int32_t* ids, float* values);
bool load_pair(const std::int32_t* ids, const float* values, int num_shape_pairs,
               ContactPair& pair);

}  // namespace engram
