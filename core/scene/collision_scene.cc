#include "core/scene/collision_scene.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "core/base/error.h"
#include "core/base/index.h"

namespace engram {
namespace {

// Below this share of the sliding friction there is no torsional friction.
constexpr double kMinTorsionRadius = 1e-3;  // m

// A box whose top is a plane.
constexpr double kPlaneHalfExtent = 50;  // m

[[noreturn]] void refuse_scene(const std::string& why) { throw Error(Error::kInternal, why); }

std::string body_name(const mjModel& model, int body) {
  const char* name = mj_id2name(&model, mjOBJ_BODY, body);
  return name == nullptr ? "" : name;
}

// Link of the robot that a body is.
int link_named(const mjModel& model, int body) {
  const std::string name = body_name(model, body);
  if (name == "leftfinger") return kLeftFingerLink;
  if (name == "rightfinger") return kRightFingerLink;
  if (name == "hand") return kHandLink;
  if (name == "camera_link") return kCameraLink;
  for (int link = 0; link < kArmJoints; ++link) {
    if (name == "link" + std::to_string(link + 1)) return link;
  }
  refuse_scene("the robot has a body '" + name + "' that is none of its links");
}

bool is_free(const mjModel& model, int body) {
  const int joint = model.body_jntadr[body];
  return joint >= 0 && model.jnt_type[joint] == mjJNT_FREE;
}

int rank(BodyKind kind) {
  switch (kind) {
    case BodyKind::kLink:
      return 0;
    case BodyKind::kFree:
      return 1;
    case BodyKind::kKinematic:
    case BodyKind::kStatic:
      break;
  }
  return 2;
}

bool is_colliding(const mjModel& model, int geom) {
  for (int pair = 0; pair < model.npair; ++pair) {
    if (model.pair_geom1[pair] == geom || model.pair_geom2[pair] == geom) return true;
  }
  return false;
}

CollisionShape make_shape(const mjModel& model, int geom) {
  CollisionShape shape;
  shape.geom = geom;
  shape.type = model.geom_type[geom];
  shape.frame = make_frame(model.geom_pos + 3 * geom, model.geom_quat + 4 * geom);
  shape.half = Eigen::Map<const Vec3>(model.geom_size + 3 * geom);
  shape.bounding_radius = model.geom_rbound[geom];
  if (shape.type == mjGEOM_PLANE) {
    shape.half = Vec3::Constant(kPlaneHalfExtent);
    shape.frame.pos -= kPlaneHalfExtent * shape.frame.axes.col(2);
    shape.bounding_radius = shape.half.norm();
  }
  return shape;
}

}  // namespace

std::vector<Vec3> mesh_vertices(const mjModel& model, int mesh) {
  const float* const first = model.mesh_vert + 3 * model.mesh_vertadr[mesh];
  std::vector<Vec3> vertices;
  for (int i = 0; i < model.mesh_vertnum[mesh]; ++i) {
    vertices.push_back(Eigen::Map<const Eigen::Matrix<float, 3, 1>>(first + 3 * i).cast<double>());
  }
  return vertices;
}

CollisionScene::CollisionScene(const mjModel& model, const std::vector<std::string>& props)
    : body_of_prop_(props.size(), -1) {
  std::vector<int> shape_of_geom(at(static_cast<int>(model.ngeom)), -1);
  for (int body = 0; body < model.nbody; ++body) {
    const int first = static_cast<int>(shapes_.size());
    CollisionBody to;
    to.first_shape = first;
    add_shapes(model, body, to);
    if (to.num_shapes == 0) continue;
    const int index = static_cast<int>(bodies_.size());
    bodies_.push_back(to);
    for (int shape = first; shape < first + to.num_shapes; ++shape) {
      shapes_[at(shape)].body = index;
      shape_of_geom[at(shapes_[at(shape)].geom)] = shape;
    }
    classify_last(model, body, props);
  }
  add_pairs(model, shape_of_geom);
  add_hulls(model);
}

// Hulls of all boxes, too, in scenes with meshes.
void CollisionScene::add_hulls(const mjModel& model) {
  const auto is_mesh = [](const CollisionShape& shape) { return shape.type == mjGEOM_MESH; };
  if (std::ranges::none_of(shapes_, is_mesh)) return;
  for (CollisionShape& shape : shapes_) {
    if (is_mesh(shape)) {
      hulls_.push_back(convex_hull(mesh_vertices(model, model.geom_dataid[shape.geom])));
    } else if (shape.is_box()) {
      hulls_.push_back(box_hull(shape.half));
    } else {
      continue;
    }
    shape.hull = static_cast<int>(hulls_.size()) - 1;
  }
}

void CollisionScene::classify_last(const mjModel& model, int body,
                                   const std::vector<std::string>& props) {
  CollisionBody& to = bodies_.back();
  const int index = static_cast<int>(bodies_.size()) - 1;
  to.center = Eigen::Map<const Vec3>(model.body_ipos + 3 * body);
  const auto prop = std::find(props.begin(), props.end(), body_name(model, body));
  if (prop != props.end()) {
    to.prop = static_cast<int>(prop - props.begin());
    to.kind = is_free(model, body) ? BodyKind::kFree : BodyKind::kKinematic;
    body_of_prop_[at(to.prop)] = index;
    return;
  }
  to.of_robot = model.body_rootid[body] == model.body_rootid[model.jnt_bodyid[0]];
  to.attachment = attachment_of(model, body);
  if (to.attachment.link < 0) return;  // the table, or the robot's foot
  to.kind = BodyKind::kLink;
  to.link = link_named(model, body);
}

void CollisionScene::add_shapes(const mjModel& model, int body, CollisionBody& to) {
  Vec3 low = Vec3::Constant(1e9);
  Vec3 high = Vec3::Constant(-1e9);
  const int begin = model.body_geomadr[body];
  for (int geom = begin; geom < begin + model.body_geomnum[body]; ++geom) {
    if (!is_colliding(model, geom)) continue;
    const CollisionShape shape = make_shape(model, geom);
    low = low.cwiseMin((shape.frame.pos.array() - shape.bounding_radius).matrix());
    high = high.cwiseMax((shape.frame.pos.array() + shape.bounding_radius).matrix());
    shapes_.push_back(shape);
    ++to.num_shapes;
  }
  if (to.num_shapes == 0) return;
  to.bounding_center = 0.5 * (low + high);
  for (int i = to.first_shape; i < to.first_shape + to.num_shapes; ++i) {
    const CollisionShape& shape = shapes_[at(i)];
    to.bounding_radius = std::max(
        to.bounding_radius, (shape.frame.pos - to.bounding_center).norm() + shape.bounding_radius);
  }
}

void CollisionScene::add_pairs(const mjModel& model, const std::vector<int>& shape_of_geom) {
  // By whether the second body moves, then in order of the bodies and of their shapes: versions of
  // MuJoCo order pairs differently.
  std::map<std::array<int, 3>, std::vector<ShapePair>> grouped;
  for (int pair = 0; pair < model.npair; ++pair) {
    ShapePair entry;
    entry.a = shape_of_geom[at(model.pair_geom1[pair])];
    entry.b = shape_of_geom[at(model.pair_geom2[pair])];
    const auto body_of = [&](int shape) { return shapes_[at(shape)].body; };
    const auto rank_of = [&](int shape) { return rank(bodies_[at(body_of(shape))].kind); };
    const std::pair order_a(rank_of(entry.a), entry.a);
    const std::pair order_b(rank_of(entry.b), entry.b);
    if (order_a > order_b) std::swap(entry.a, entry.b);
    if (rank_of(entry.a) == 2) continue;  // nothing moves
    const mjtNum* friction = model.pair_friction + 5 * pair;
    entry.friction = friction[0];
    const double radius = friction[0] > 0 ? friction[2] / friction[0] : 0;
    entry.torsion_radius = radius > kMinTorsionRadius ? radius : 0;
    const int fixed = rank_of(entry.b) == 2 ? 1 : 0;
    grouped[{fixed, body_of(entry.a), body_of(entry.b)}].push_back(entry);
  }
  for (auto& [key, pairs] : grouped) {
    std::ranges::sort(pairs, {}, [](const ShapePair& pair) { return std::pair(pair.a, pair.b); });
    body_pairs_.push_back(
        {key[1], key[2], static_cast<int>(shape_pairs_.size()), static_cast<int>(pairs.size())});
    shape_pairs_.insert(shape_pairs_.end(), pairs.begin(), pairs.end());
  }
}

int CollisionScene::num_free_shapes() const {
  int sum = 0;
  for (const CollisionBody& body : bodies_) {
    if (body.kind == BodyKind::kFree) sum += body.num_shapes;
  }
  return sum;
}

}  // namespace engram
