// Lower bounds of distances, which wake props, against MuJoCo's own collision detection.
#include "core/scene/proximity.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/math/random.h"
#include "core/scene/physics_model.h"
#include "mjcf/object_shapes.h"
#include "tasks/common/task_info.h"

namespace engram {
namespace {

constexpr double kRadius = 0.06;  // m, of the probing sphere

Eigen::Vector3d random_point(RandomStream& random, double spread) {
  const double x = random.uniform(-spread, spread);
  const double y = random.uniform(-spread, spread);
  return {x, y, random.uniform(-spread, spread)};
}

void random_pose(RandomStream& random, double spread, mjtNum* pos, mjtNum* quat) {
  Eigen::Map<Eigen::Vector3d>(pos, 3) = random_point(random, spread);
  for (int i = 0; i < 4; ++i) quat[i] = random.normal();
  mju_normalize4(quat);
}

// Counts of a probing sphere that reaches a geom and that touches it.
struct Counts {
  int rounds = 0;
  int touches = 0;
  int reached = 0;
  int missed = 0;
  int promised = 0;  // still no touch when the sphere has come as near as it may
};

Counts probe(const std::string& shape) {
  const ModelPtr model =
      compile_model("<mujoco><worldbody><body mocap='true'><geom name='a' " + shape +
                    "/></body><body mocap='true'><geom name='b' size='.06'/></body></worldbody>"
                    "<contact><pair geom1='a' geom2='b'/></contact></mujoco>");
  const DataPtr data = make_data(*model);
  RandomStream random(1, 0, 0);
  CollisionShape probed;
  probed.type = model->geom_type[0];
  probed.half = Eigen::Map<const Vec3>(model->geom_size);
  probed.bounding_radius = model->geom_rbound[0];
  Counts counts;
  for (counts.rounds = 0; counts.rounds < 5000; ++counts.rounds) {
    random_pose(random, 0.2, data->mocap_pos, data->mocap_quat);
    random_pose(random, 0.2, data->mocap_pos + 3, data->mocap_quat + 4);
    mj_kinematics(model.get(), data.get());
    mj_collision(model.get(), data.get());
    const Eigen::Map<const Eigen::Vector3d> center(data->geom_xpos + 3);
    const Frame frame = {Eigen::Map<const Vec3>(data->geom_xpos),
                         Eigen::Map<const RowMat3>(data->geom_xmat)};
    const double distance = sphere_clearance(probed, frame, center, kRadius);
    const bool reaches = distance <= 0;
    counts.touches += data->ncon > 0 ? 1 : 0;
    counts.reached += reaches ? 1 : 0;
    counts.missed += data->ncon > 0 && !reaches ? 1 : 0;
    if (reaches) continue;
    Eigen::Map<Eigen::Vector3d> sphere(data->mocap_pos + 3);
    sphere -=
        (distance - 1e-9) * (sphere - Eigen::Map<Eigen::Vector3d>(data->mocap_pos)).normalized();
    mj_kinematics(model.get(), data.get());
    mj_collision(model.get(), data.get());
    counts.missed += data->ncon > 0 ? 1 : 0;
    counts.promised += data->ncon > 0 ? 0 : 1;
  }
  return counts;
}

TEST_CASE("A sphere reaches boxes, capsules and spheres exactly when it touches them",
          "[proximity]") {
  for (const char* shape : {"type='box' size='.1 .05 .2'", "type='capsule' size='.05 .15'",
                            "type='sphere' size='.1'"}) {
    const Counts counts = probe(shape);
    INFO(shape);
    CHECK(counts.missed == 0);
    CHECK(counts.reached == counts.touches);
    CHECK(counts.touches > 500);
    CHECK(counts.promised > 500);
  }
}

TEST_CASE("A sphere that touches any other shape is never missed", "[proximity]") {
  for (const char* shape :
       {"type='cylinder' size='.05 .15'", "type='ellipsoid' size='.05 .1 .15'"}) {
    const Counts counts = probe(shape);
    INFO(shape);
    CHECK(counts.missed == 0);
    CHECK(counts.reached >= counts.touches);
    CHECK(counts.touches > 500);
    CHECK(counts.promised > 500);
  }
}

// Free props of a scene in MuJoCo's data.
class Props {
 public:
  explicit Props(const PhysicsModel& physics) : model_(physics.full()), data_(make_data(model_)) {
    prop_of_body_.assign(static_cast<std::size_t>(model_.nbody), -1);
    for (const PropModel& prop : physics.props()) {
      const int body = mj_name2id(&model_, mjOBJ_BODY, prop.name.c_str());
      prop_of_body_[static_cast<std::size_t>(body)] = static_cast<int>(qpos_.size());
      qpos_.push_back(model_.jnt_qposadr[model_.body_jntadr[body]]);
    }
  }

  int count() const { return static_cast<int>(qpos_.size()); }
  // Position and quaternion.
  mjtNum* pose(int prop) { return data_->qpos + qpos_[static_cast<std::size_t>(prop)]; }

  // Pairs of props that have a contact, in order.
  std::set<std::pair<int, int>> touching() {
    mj_kinematics(&model_, data_.get());
    mj_collision(&model_, data_.get());
    std::set<std::pair<int, int>> touches;
    for (int i = 0; i < data_->ncon; ++i) {
      const auto prop_of = [&](int geom) {
        return prop_of_body_[static_cast<std::size_t>(model_.geom_bodyid[geom])];
      };
      const int a = prop_of(data_->contact[i].geom1);
      const int b = prop_of(data_->contact[i].geom2);
      if (a >= 0 && b >= 0) touches.emplace(std::min(a, b), std::max(a, b));
    }
    return touches;
  }

 private:
  const mjModel& model_;
  DataPtr data_;
  std::vector<int> prop_of_body_;  // or -1
  std::vector<int> qpos_;          // addresses
};

mjcf::Scene one_of_each_shape() {
  mjcf::Scene scene;
  for (int i = 0; i < mjcf::kObjectShapeCount; ++i) {
    scene.props.push_back(mjcf::shape_prop("shape_" + std::to_string(i),
                                           static_cast<mjcf::ObjectShape>(i), {0, 0, 1, 1}));
  }
  return scene;
}

TEST_CASE("Shapes do not touch when they have come nearer by less than they were apart",
          "[proximity]") {
  const PhysicsModel physics(tasks::scene_source(one_of_each_shape()));
  Props props(physics);
  for (int prop = 0; prop < props.count(); ++prop) props.pose(prop)[0] = 1000.0 + 10.0 * prop;
  RandomStream random(5, 0, 0);
  constexpr double kGap = 0.002;
  int moved = 0;
  for (int round = 0; round < 3000; ++round) {
    const int a = round % mjcf::kObjectShapeCount;
    const int b = (a + 1 + round % (mjcf::kObjectShapeCount - 1)) % mjcf::kObjectShapeCount;
    mjtNum* poses[2];
    Frame frames[2];
    for (int i = 0; i < 2; ++i) {
      poses[i] = props.pose(i == 0 ? a : b);
      random_pose(random, 0.06, poses[i], poses[i] + 3);
      frames[i] = make_frame(poses[i], poses[i] + 3);
    }
    const double clearance =
        parts_clearance(kGap, physics.props()[static_cast<std::size_t>(a)].parts, frames[0],
                        physics.props()[static_cast<std::size_t>(b)].parts, frames[1]);
    if (clearance > 0) {
      Eigen::Map<Eigen::Vector3d> second(poses[1]);
      second -= (clearance + kGap - 1e-9) * (second - frames[0].pos).normalized();
      REQUIRE(props.touching().count({std::min(a, b), std::max(a, b)}) == 0);
      ++moved;
    }
    for (int i = 0; i < 2; ++i) poses[i][0] = 1000.0 + 10.0 * (i == 0 ? a : b);
  }
  CHECK(moved > 1000);
}

TEST_CASE("Shapes that touch are near, and those far apart are not", "[proximity]") {
  const PhysicsModel physics(tasks::scene_source(one_of_each_shape()));
  Props props(physics);
  RandomStream random(4, 0, 0);
  const MujocoScope scope;  // nine shapes in a knot may have more contacts than fit
  int touching = 0;
  int near = 0;
  int spheres = 0;
  for (int round = 0; round < 1500; ++round) {
    std::vector<Frame> frames;
    for (int prop = 0; prop < props.count(); ++prop) {
      random_pose(random, 0.06, props.pose(prop), props.pose(prop) + 3);
      frames.push_back(make_frame(props.pose(prop), props.pose(prop) + 3));
    }
    const std::set<std::pair<int, int>> touches = props.touching();
    for (int a = 0; a < mjcf::kObjectShapeCount; ++a) {
      for (int b = a + 1; b < mjcf::kObjectShapeCount; ++b) {
        const PropModel& first = physics.props()[static_cast<std::size_t>(a)];
        const PropModel& second = physics.props()[static_cast<std::size_t>(b)];
        const Frame& frame_a = frames[static_cast<std::size_t>(a)];
        const Frame& frame_b = frames[static_cast<std::size_t>(b)];
        const bool is_near = parts_clearance(0, first.parts, frame_a, second.parts, frame_b) <= 0;
        if (touches.count({a, b}) > 0) REQUIRE(is_near);
        touching += static_cast<int>(touches.count({a, b}));
        near += is_near ? 1 : 0;
        const double apart = (frame_a.pos + frame_a.axes * first.bounding_center - frame_b.pos -
                              frame_b.axes * second.bounding_center)
                                 .norm();
        spheres += apart < first.bounding_radius + second.bounding_radius ? 1 : 0;
      }
    }
  }
  CHECK(touching > 3000);
  CHECK(near < 1.2 * touching);
  CHECK(spheres > 2 * touching);
}

}  // namespace
}  // namespace engram
