// Bodies and shapes that collide, and which pairs of them may: read from a compiled scene.
#pragma once

#include <mujoco/mujoco.h>

#include <string>
#include <vector>

#include "core/base/index.h"
#include "core/math/convex_hull.h"
#include "core/robot/robot_pose.h"

namespace engram {

enum class BodyKind {
  kLink,       // of the robot
  kFree,       // a prop that physics moves
  kKinematic,  // a prop that a task moves
  kStatic,     // table and ground
};

struct CollisionShape {
  int geom = -1;             // of the model
  int type = 0;              // mjtGeom; a plane counts as the top of a large box
  int body = -1;             // of the CollisionScene
  Frame frame;               // in the body's
  Vec3 half = Vec3::Zero();  // extents of a box; MuJoCo's sizes of other shapes, m
  double bounding_radius = 0;
  int hull = -1;  // of the scene: of meshes, and of boxes that may touch some

  bool is_box() const { return type == mjGEOM_BOX || type == mjGEOM_PLANE; }
};

struct CollisionBody {
  BodyKind kind = BodyKind::kStatic;
  int prop = -1;                        // of the task, or -1
  int link = -1;                        // of the robot (kNumLinks), or -1
  bool of_robot = false;                // a link, or the foot, which is static
  Attachment attachment;                // of a link
  Vec3 center = Vec3::Zero();           // of mass, in the body's frame, m
  Vec3 bounding_center = Vec3::Zero();  // of a sphere around all shapes, in the body's frame
  double bounding_radius = 0;
  int first_shape = 0;
  int num_shapes = 0;
};

// A pair of shapes that may touch. A is a link or a prop, B a prop or static; what moves comes
// first.
struct ShapePair {
  int a = 0;
  int b = 0;
  double friction = 0;        // mean of both materials
  double torsion_radius = 0;  // of the contact patch, m; 0: no torsional friction
};

// All shape pairs of two bodies, one after the other.
struct BodyPair {
  int a = 0;
  int b = 0;
  int first = 0;
  int count = 0;
};

// Vertices of a mesh of the model, in the frame of its geoms.
std::vector<Vec3> mesh_vertices(const mjModel& model, int mesh);

class CollisionScene {
 public:
  CollisionScene() = default;
  // `props`: names of the task's props. Throws Error if the robot has a body that is none of its
  // links.
  CollisionScene(const mjModel& model, const std::vector<std::string>& props);

  const std::vector<CollisionBody>& bodies() const { return bodies_; }
  const std::vector<CollisionShape>& shapes() const { return shapes_; }
  const std::vector<ShapePair>& shape_pairs() const { return shape_pairs_; }
  // Pairs of two moving bodies come first, then those of a moving and a static or kinematic one.
  const std::vector<BodyPair>& body_pairs() const { return body_pairs_; }
  const ConvexHull& hull(const CollisionShape& shape) const { return hulls_[at(shape.hull)]; }
  // Shapes of free props.
  int num_free_shapes() const;
  // Body of a prop, or -1 if nothing of it collides.
  int body_of_prop(int prop) const { return body_of_prop_[at(prop)]; }

 private:
  void add_shapes(const mjModel& model, int body, CollisionBody& to);
  // Sets kind and identity of the last body.
  void classify_last(const mjModel& model, int body, const std::vector<std::string>& props);
  void add_pairs(const mjModel& model, const std::vector<int>& shape_of_geom);

  void add_hulls(const mjModel& model);

  std::vector<CollisionBody> bodies_;
  std::vector<CollisionShape> shapes_;
  std::vector<ShapePair> shape_pairs_;
  std::vector<ConvexHull> hulls_;
  std::vector<BodyPair> body_pairs_;
  std::vector<int> body_of_prop_;
};

}  // namespace engram
