// Memory of the broad phase for environments side by side: plain numbers, for the kernels of all
// instruction sets. A row has one double for each lane.
#pragma once

#include "core/robot/robot_model.h"

namespace engram {

// A pair of shapes that are near each other in these lanes (bits).
struct NearShapes {
  int shape_pair;
  unsigned lanes;
};

struct BroadPhaseLanes {
  static constexpr int kFrameRows = 3 + 9;  // position, axes row by row; m, world
  static constexpr int kCenter = 0;         // of a body's bounding sphere, m
  static constexpr int kSpeed = 3;          // upper bound of any of its points', m/s
  static constexpr int kTravel = 4;         // in the substep, m
  static constexpr int kBodyRows = 5;

  struct Body {
    int frame = -1;  // that its shapes are fixed to: of a robot's joint or a prop; -1: static
    int link = -1;   // of the robot, or -1
    double center[3] = {};
    double radius = 0;
    double speed_gain = 0;  // m/s: what acceleration may add in a substep
  };
  struct Shape {
    int frame = -1;  // -1: static
    bool is_box = false;
    double pos[3] = {};   // in that frame
    double axes[9] = {};  // row by row
    double half[3] = {};  // of a box, m
    double radius = 0;    // of a sphere around it, m
  };
  struct ShapePair {
    int a, b;
    double near_gap;   // m
    double max_reach;  // near_gap and travel count up to this, m
  };
  struct BodyPair {
    int a, b;
    int first, count;  // shape pairs
    int box;           // the only shape of B, if it is a box, or -1
    double near_gap;   // the largest of its shape pairs, m
  };

  // --- the same in all lanes ---
  const Body* body = nullptr;
  int num_bodies = 0;
  const Shape* shape = nullptr;
  int num_shapes = 0;
  const ShapePair* shape_pair = nullptr;
  const BodyPair* body_pair = nullptr;
  int num_body_pairs = 0;
  double timestep = 0;

  // --- rows ---
  double* frames = nullptr;
  double* bodies = nullptr;
  double* shapes = nullptr;  // frames in the world, where they are posed

  bool* is_posed = nullptr;           // shapes in this substep
  const unsigned* present = nullptr;  // lanes that have a body, as bits
  NearShapes* near = nullptr;         // result, in the order of shape pairs
  int num_near = 0;
};

}  // namespace engram
