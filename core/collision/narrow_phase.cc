#include "core/collision/narrow_phase.h"

#include <algorithm>
#include <limits>

#include "core/base/index.h"
#include "core/collision/cylinder_box.h"
#include "core/collision/hull_hull.h"

namespace engram {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kMaxFound = 64;  // contacts of one pair that MuJoCo may find

bool is_cylinder(const CollisionShape& shape) { return shape.type == mjGEOM_CYLINDER; }

bool has_hulls(const CollisionShape& a, const CollisionShape& b) {
  return a.hull >= 0 && b.hull >= 0;
}

CylinderPose cylinder_at(const CollisionShape& shape, const Frame& frame) {
  return {shape.half[0], shape.half[1], frame};
}

// Seen from the other shape.
ContactPoints swapped(const ContactPoints& points) {
  ContactPoints result;
  for (const ContactPoint& point : points) {
    result.push({point.pos + point.normal * point.gap, -point.normal, point.gap});
  }
  return result;
}

}  // namespace

NarrowPhase::NarrowPhase(const mjModel& model, const CollisionScene& scene)
    : model_(model), scene_(scene), data_(make_data_lazy_contacts(model)), found_(kMaxFound) {
  mj_kinematics(&model_, data_.get());
  for (const ShapePair& pair : scene.shape_pairs()) {
    limits_.push_back(
        manifold_limits(scene.shapes()[at(pair.a)].half, scene.shapes()[at(pair.b)].half));
  }
}

ContactPoints NarrowPhase::find(int shape_pair, const Frame& a, const Frame& b, double reach,
                                ContactPair& pair) {
  const ShapePair& shapes = scene_.shape_pairs()[at(shape_pair)];
  const CollisionShape& shape_a = scene_.shapes()[at(shapes.a)];
  const CollisionShape& shape_b = scene_.shapes()[at(shapes.b)];
  if (shape_a.is_box() && shape_b.is_box()) return find_boxes(shape_pair, a, b, pair);
  if (is_cylinder(shape_a) && shape_b.is_box()) {
    return cylinder_box(cylinder_at(shape_a, a), {shape_b.half, b}, kContactReach);
  }
  if (shape_a.is_box() && is_cylinder(shape_b)) {
    return swapped(cylinder_box(cylinder_at(shape_b, b), {shape_a.half, a}, kContactReach));
  }
  if (has_hulls(shape_a, shape_b)) {
    return hull_hull({scene_.hull(shape_a), a}, {scene_.hull(shape_b), b}, reach);
  }
  return collide(shapes, a, b, reach);
}

double NarrowPhase::separation(int shape_pair, const Frame& a, const Frame& b) const {
  const ShapePair& shapes = scene_.shape_pairs()[at(shape_pair)];
  const CollisionShape& shape_a = scene_.shapes()[at(shapes.a)];
  const CollisionShape& shape_b = scene_.shapes()[at(shapes.b)];
  if (shape_a.is_box() && shape_b.is_box()) {
    return box_separation({shape_a.half, a}, {shape_b.half, b});
  }
  if (is_cylinder(shape_a) && shape_b.is_box()) {
    return cylinder_box_separation(cylinder_at(shape_a, a), {shape_b.half, b});
  }
  if (shape_a.is_box() && is_cylinder(shape_b)) {
    return cylinder_box_separation(cylinder_at(shape_b, b), {shape_a.half, a});
  }
  if (has_hulls(shape_a, shape_b)) {
    return hull_separation({scene_.hull(shape_a), a}, {scene_.hull(shape_b), b});
  }
  return -kInfinity;
}

const Eigen::Vector4d& NarrowPhase::quat_of(const Mat3& axes) {
  for (const KnownQuat& known : quats_) {
    if (known.axes == axes) return known.quat;
  }
  KnownQuat& added = quats_[oldest_quat_];
  oldest_quat_ = (oldest_quat_ + 1) % quats_.size();
  added = {axes, manifold_quat(axes)};
  return added.quat;
}

ContactPoints NarrowPhase::find_boxes(int shape_pair, const Frame& a, const Frame& b,
                                      ContactPair& pair) {
  const ShapePair& shapes = scene_.shape_pairs()[at(shape_pair)];
  const BoxPose box_a = {scene_.shapes()[at(shapes.a)].half, a};
  const BoxPose box_b = {scene_.shapes()[at(shapes.b)].half, b};
  const ManifoldBox of_a(box_a, quat_of(a.axes));
  const ManifoldBox of_b(box_b, quat_of(b.axes));
  if (refresh_manifold(pair.manifold, of_a, of_b, limits_[at(shape_pair)])) {
    find_manifold(pair.manifold, of_a, of_b, kContactReach);
  }
  return manifold_points(pair.manifold, box_a, box_b, kContactReach);
}

void NarrowPhase::pose(int shape, const Frame& frame) {
  const CollisionShape& of = scene_.shapes()[at(shape)];
  if (of.type == mjGEOM_PLANE) return;  // static
  Eigen::Map<Vec3>(data_->geom_xpos + 3 * of.geom) = frame.pos;
  Eigen::Map<RowMat3>(data_->geom_xmat + 9 * of.geom) = frame.axes;
}

ContactPoints NarrowPhase::collide(const ShapePair& pair, const Frame& a, const Frame& b,
                                   double reach) {
  pose(pair.a, a);
  pose(pair.b, b);
  int first = scene_.shapes()[at(pair.a)].geom;
  int second = scene_.shapes()[at(pair.b)].geom;
  const bool swapped = model_.geom_type[first] > model_.geom_type[second];
  if (swapped) std::swap(first, second);
  const mjfCollision function = mjCOLLISIONFUNC[model_.geom_type[first]][model_.geom_type[second]];
  ContactPoints points;
  if (function == nullptr) return points;
  const int count = function(&model_, data_.get(), found_.data(), first, second, reach);
  const bool on_a = scene_.shapes()[at(pair.b)].type == mjGEOM_SPHERE;
  for (int i = 0; i < std::min(count, Manifold::kMaxPoints); ++i) {
    const MujocoContact& contact = found_[at(i)];
    const Vec3 from_first = Eigen::Map<const Vec3>(normal_of(contact));
    const Vec3 normal = swapped ? from_first : Vec3(-from_first);
    const double to_surface = (on_a ? 0.5 : -0.5) * contact.dist;
    points.push({Eigen::Map<const Vec3>(contact.pos) + to_surface * normal, normal, contact.dist});
  }
  return points;
}

}  // namespace engram
