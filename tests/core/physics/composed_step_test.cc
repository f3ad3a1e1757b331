// The composed step: free props against all of MuJoCo's stages, bit for bit; the robot among
// contacts.
#include "core/physics/composed_step.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/physics/contacts.h"
#include "core/physics/model.h"
#include "core/physics/pair_sieve.h"
#include "core/physics/sliding.h"
#include "mjcf/ball.h"
#include "mjcf/scene.h"
#include "mjcf/shapes.h"
#include "tasks/parts/task_info.h"

namespace engram {
namespace {

mjcf::Scene cubes(int count) {
  mjcf::Scene scene;
  for (int i = 0; i < count; ++i) {
    scene.props.push_back(mjcf::cube("cube_" + std::to_string(i), 0.02, {1, 0, 0, 1}));
  }
  return scene;
}

mjcf::Scene nine_shapes() {
  mjcf::Scene scene;
  for (int i = 0; i < mjcf::kObjectShapeCount; ++i) {
    scene.props.push_back(mjcf::shape_prop("shape_" + std::to_string(i),
                                           static_cast<mjcf::ObjectShape>(i), {0, 0, 1, 1}));
  }
  return scene;
}

// A scene as the engine runs it: without drives, and with weights that it applies itself.
struct Compiled {
  explicit Compiled(int cube_count) : Compiled(cubes(cube_count)) {}
  explicit Compiled(const mjcf::Scene& scene) : model(tasks::scene_source(scene)) {
    for (const mjcf::Prop& prop : scene.props) {
      const int body = mj_name2id(&model.full(), mjOBJ_BODY, prop.name.c_str());
      const int joint = model.full().body_jntadr[body];
      qpos.push_back(model.full().jnt_qposadr[joint]);
      dof.push_back(model.full().jnt_dofadr[joint]);
      weight.push_back(prop.mass * 9.81);
    }
  }
  // Rows of cubes on the table, far from the robot.
  void lay_out(mjData* data) const {
    for (std::size_t i = 0; i < qpos.size(); ++i) {
      double* pos = data->qpos + qpos[i];
      const std::size_t row = i / 3;
      pos[0] = -0.1 + 0.1 * static_cast<double>(i % 3);
      pos[1] = -0.3 + 0.1 * static_cast<double>(row);
    }
  }
  void apply_weights(mjData* data) const {
    for (std::size_t i = 0; i < dof.size(); ++i) data->qfrc_applied[dof[i] + 2] = -weight[i];
  }

  PhysicsModel model;
  std::vector<int> qpos;
  std::vector<int> dof;
  std::vector<double> weight;  // N
};

constexpr std::array kStart = {0.0, 0.0, 0.0, -2.0943951, 0.0, 2.0943951, 0.78539816, 0.04, 0.04};

bool same(const mjtNum* a, const mjtNum* b, int count) {
  return std::memcmp(a, b, static_cast<std::size_t>(count) * sizeof(mjtNum)) == 0;
}

// Drives that do nothing.
RobotStep::Law no_drives(const PhysicsModel& model) {
  RobotStep::Law law = model.robot_law();
  law.drive = {};
  return law;
}

// All stages of mj_step, with what the engine does to contacts in between.
void step_in_full(const mjModel* m, mjData* d) {
  mj_kinematics(m, d);
  mj_comPos(m, d);
  mj_camlight(m, d);
  mj_tendon(m, d);
  mj_crb(m, d);
  mj_factorM(m, d);
  mj_comVel(m, d);
  mj_collision(m, d);
  refine_contacts(*m, *d);
  mj_makeConstraint(m, d);
  mj_transmission(m, d);
  mj_fwdVelocity(m, d);
  mj_fwdActuation(m, d);
  mj_fwdAcceleration(m, d);
  slide_freely(*m, *d);
  mj_fwdConstraint(m, d);
  mj_Euler(m, d);
}

// Two data of a model, one stepped by MuJoCo's stages, the other by the composed step. The robot is
// at rest and out of reach.
struct Twins {
  explicit Twins(const Compiled& compiled)
      : scene(compiled),
        model(compiled.model.full()),
        sieve(model),
        law(no_drives(compiled.model)),
        robot(law, {}),
        mine(make_data(model)),
        theirs(make_data(model)) {
    for (mjData* data : {mine.get(), theirs.get()}) {
      std::copy(kStart.begin(), kStart.end(), data->qpos);
    }
  }

  void step() {
    scene.apply_weights(theirs.get());
    std::copy_n(theirs->qfrc_applied, model.nv, mine->qfrc_applied);
    step_in_full(&model, theirs.get());
    compose_kinematics(&model, mine.get());
    compose_dynamics({&model, sieve.near_pairs(*mine), &scene.model.scenes().back().solving},
                     mine.get(), robot);
    contacts += mine->ncon;
  }
  bool equal() const {
    return same(mine->qpos, theirs->qpos, model.nq) && same(mine->qvel, theirs->qvel, model.nv) &&
           same(mine->qacc_warmstart, theirs->qacc_warmstart, model.nv) &&
           mine->time == theirs->time;
  }

  const Compiled& scene;
  const mjModel& model;
  PairSieve sieve;
  RobotStep::Law law;
  RobotStep robot;
  DataPtr mine;
  DataPtr theirs;
  long contacts = 0;
};

// A heap that falls onto the table and onto itself.
void check_heap(const Compiled& scene, int steps, int contacts_per_step = 5) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    RandomStream random(seed, 1, 0);
    Twins twins(scene);
    for (const int address : scene.qpos) {
      const double pos[3] = {random.uniform(-0.1, 0.05), random.uniform(0.5, 0.7),
                             random.uniform(0.05, 0.3)};
      double quat[4] = {random.normal(), random.normal(), random.normal(), random.normal()};
      mju_normalize4(quat);
      for (mjData* data : {twins.mine.get(), twins.theirs.get()}) {
        std::copy_n(pos, 3, data->qpos + address);
        std::copy_n(quat, 4, data->qpos + address + 3);
      }
    }
    for (int i = 0; i < steps; ++i) {
      twins.step();
      REQUIRE(twins.equal());
    }
    CHECK(twins.contacts > contacts_per_step * steps);
  }
}

TEST_CASE("The composed step equals the full one with falling and colliding cubes", "[physics]") {
  check_heap(Compiled(9), 1000);
}

TEST_CASE("The composed step equals the full one with falling and colliding shapes", "[physics]") {
  check_heap(Compiled(nine_shapes()), 300);
}

TEST_CASE("The composed step equals the full one with balls, whose rolling is damped",
          "[physics]") {
  mjcf::Scene scene;
  for (int i = 0; i < 3; ++i) {
    scene.props.push_back(mjcf::ball("ball_" + std::to_string(i), 0.03, {1, 0, 0, 1}));
  }
  check_heap(Compiled(scene), 400, 2);
}

// One robot in one of a model's scenes, under drives.
struct Driven {
  Driven(const Compiled& compiled, int scene_index)
      : scene(compiled.model.scenes()[static_cast<std::size_t>(scene_index)]),
        data(make_data(*scene.model)) {
    std::copy(kStart.begin(), kStart.end(), data->qpos);
  }
  void step(const RobotStep::Law& law, const Drive& drive) const {
    RobotStep robot(law, drive);
    compose_kinematics(scene.model.get(), data.get());
    compose_dynamics({scene.model.get(), scene.model.get(), &scene.solving}, data.get(), robot);
  }

  const SceneModel& scene;
  DataPtr data;
};

// What the shortcut of stepping the robot alone rests on. Joints meet their limits here.
TEST_CASE("The robot moves the same with resting cubes in the scene and without", "[physics]") {
  const Compiled scene(9);
  const RobotStep::Law& law = scene.model.robot_law();
  int at_limits = 0;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    RandomStream random(seed, 2, 0);
    const Driven alone(scene, PhysicsModel::kDynamicsScene);
    const Driven full(scene, scene.model.full_scene());
    scene.lay_out(full.data.get());
    Drive drive;
    for (int i = 0; i < 2000; ++i) {
      if (i % 20 == 0) {
        for (std::size_t joint = 0; joint < kRobotJoints; ++joint) {
          drive.target[joint] = kStart[joint] + random.uniform(-0.3, 0.3);
        }
        drive.target[6] = 3.5;
      }
      scene.apply_weights(full.data.get());
      alone.step(law, drive);
      full.step(law, drive);
      at_limits += alone.data->qpos[6] >= law.upper[6] ? 1 : 0;
      REQUIRE(alone.data->ncon == 0);
      REQUIRE(full.data->ncon >= 36);
      REQUIRE(same(alone.data->qpos, full.data->qpos, kRobotJoints));
      REQUIRE(same(alone.data->qvel, full.data->qvel, kRobotJoints));
    }
  }
  CHECK(at_limits > 1000);
}

// The hand rests on a cube and is driven away from it: the contact is there, its force is not.
TEST_CASE("A contact without force leaves the robot's motion alone, to the bit", "[physics]") {
  const Compiled scene(1);
  const Driven alone(scene, PhysicsModel::kDynamicsScene);
  const Driven touching(scene, scene.model.full_scene());
  mj_kinematics(touching.scene.model.get(), touching.data.get());
  const int tip = mj_name2id(touching.scene.model.get(), mjOBJ_BODY, "leftfinger");
  double* cube = touching.data->qpos + scene.qpos[0];
  std::copy_n(touching.data->xpos + 3 * tip, 3, cube);
  cube[2] -= 0.045 + 0.0095 + 0.02;  // a finger's length below, and half a cube
  Drive up;
  std::copy(kStart.begin(), kStart.end(), up.target.begin());
  up.target[1] -= 0.3;
  for (mjData* data : {alone.data.get(), touching.data.get()}) data->qvel[1] = -1;
  scene.apply_weights(touching.data.get());
  alone.step(scene.model.robot_law(), up);
  touching.step(scene.model.robot_law(), up);
  CHECK(touching.data->ncon > 0);
  CHECK(same(alone.data->qpos, touching.data->qpos, kRobotJoints));
  CHECK(same(alone.data->qvel, touching.data->qvel, kRobotJoints));
}

}  // namespace
}  // namespace engram
