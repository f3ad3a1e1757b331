// Convex hulls of few corners: their flat faces and edges.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/index.h"
#include "core/math/eigen_types.h"

namespace engram {

struct ConvexHull {
  static constexpr int kMaxCorners = 64;                 // as PhysX has it for GPUs
  static constexpr int kMaxFaces = 2 * kMaxCorners - 4;  // of triangles, by Euler's formula
  static constexpr int kMaxEdges = 3 * kMaxCorners - 6;

  // Points p of its plane have normal . p = offset; the normal points outwards.
  struct Face {
    Vec3 normal;
    double offset = 0;
    int first = 0;  // corners in `loops`, counter-clockwise seen from outside
    int count = 0;
  };
  struct Edge {
    int from = 0;  // corners
    int to = 0;
    int left = 0;  // faces; the one in whose loop `to` follows `from`, and the other
    int right = 0;
  };

  std::vector<Vec3> corners;
  std::vector<int> loops;
  std::vector<Face> faces;
  std::vector<Edge> edges;

  std::span<const int> loop(const Face& face) const {
    return std::span(loops).subspan(at(face.first), at(face.count));
  }
};

// The hull of points. Corners that stand out by less than a ten-thousandth of its size are left
// out; if there are more than kMaxCorners, those remain that stand out most. Throws Error
// (kInvalidArgument) if points are flat.
ConvexHull convex_hull(std::span<const Vec3> points);

// A box as a hull.
ConvexHull box_hull(const Vec3& half);

// Integrals over a hull's volume: of 1, of x, of x x^T.
struct HullMoments {
  double volume = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
};
HullMoments moments_of(const ConvexHull& hull);

}  // namespace engram
