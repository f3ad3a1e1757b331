// The composed step against MuJoCo's own, bit for bit.
#include "core/physics/composed_step.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/physics/model.h"
#include "core/physics/pair_sieve.h"
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

// A scene as the engine runs it: drives that are plain motors, and weights that it applies itself.
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
      pos[0] = -0.1 + 0.1 * static_cast<double>(i % 3);
      pos[1] = -0.3 + 0.1 * static_cast<double>(i / 3);
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

// Random torques that reach joint limits and the table now and then.
void random_control(mjData* data, RandomStream& random) {
  for (int i = 0; i < kRobotJoints; ++i) data->ctrl[i] = random.uniform(-60, 60);
}

// Two data of a model, one stepped by MuJoCo, the other by the composed step.
struct Twins {
  explicit Twins(const mjModel& m) : model(m), sieve(m), mine(make_data(m)), theirs(make_data(m)) {}

  void step(RandomStream& random, const Compiled& scene) {
    if (steps++ % 7 == 0) random_control(theirs.get(), random);
    if (&model == &scene.model.full()) scene.apply_weights(theirs.get());
    std::copy_n(theirs->ctrl, model.nu, mine->ctrl);
    std::copy_n(theirs->qfrc_applied, model.nv, mine->qfrc_applied);
    mj_step(&model, theirs.get());
    compose_kinematics(&model, mine.get());
    compose_dynamics(&model, mine.get(), sieve.near_pairs(*mine));
    contacts += mine->ncon;
    limits += mine->nefc - 4 * mine->ncon;
  }
  bool equal() const {
    return same(mine->qpos, theirs->qpos, model.nq) && same(mine->qvel, theirs->qvel, model.nv) &&
           same(mine->qacc_warmstart, theirs->qacc_warmstart, model.nv) &&
           mine->time == theirs->time;
  }

  const mjModel& model;
  PairSieve sieve;
  DataPtr mine;
  DataPtr theirs;
  int steps = 0;
  long contacts = 0;
  long limits = 0;
};

TEST_CASE("The composed step equals mj_step on the robot bit for bit", "[physics]") {
  const Compiled scene(0);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    RandomStream random(seed, 0, 0);
    Twins twins(scene.model.robot());
    for (int i = 0; i < 3000; ++i) {
      twins.step(random, scene);
      REQUIRE(twins.equal());
    }
    CHECK(twins.limits > 100);  // the hard cases did occur
  }
}

// A heap that falls onto the table and onto itself, in reach of the hand.
void check_heap(const Compiled& scene, int steps, int contacts_per_step = 5) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    RandomStream random(seed, 1, 0);
    Twins twins(scene.model.full());
    for (const int address : scene.qpos) {
      const double pos[3] = {random.uniform(-0.1, 0.05), random.uniform(-0.1, 0.1),
                             random.uniform(0.05, 0.3)};
      double quat[4] = {random.normal(), random.normal(), random.normal(), random.normal()};
      mju_normalize4(quat);
      for (mjData* data : {twins.mine.get(), twins.theirs.get()}) {
        std::copy_n(pos, 3, data->qpos + address);
        std::copy_n(quat, 4, data->qpos + address + 3);
      }
    }
    for (int i = 0; i < steps; ++i) {
      twins.step(random, scene);
      REQUIRE(twins.equal());
    }
    CHECK(twins.contacts > contacts_per_step * steps);
  }
}

TEST_CASE("The composed step equals mj_step with falling and colliding cubes", "[physics]") {
  check_heap(Compiled(9), 1000);
}

TEST_CASE("The composed step equals mj_step with falling and colliding shapes", "[physics]") {
  check_heap(Compiled(nine_shapes()), 300);
}

TEST_CASE("The composed step equals mj_step with balls, whose rolling is damped", "[physics]") {
  mjcf::Scene scene;
  for (int i = 0; i < 3; ++i) {
    scene.props.push_back(mjcf::ball("ball_" + std::to_string(i), 0.03, {1, 0, 0, 1}));
  }
  check_heap(Compiled(scene), 400, 2);
}

// What the shortcut of stepping the robot alone rests on.
TEST_CASE("The robot moves the same with resting cubes in the scene and without", "[physics]") {
  const Compiled scene(9);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    RandomStream random(seed, 2, 0);
    const DataPtr alone = make_data(scene.model.robot());
    const DataPtr full = make_data(scene.model.full());
    for (mjData* data : {alone.get(), full.get()}) {
      std::copy(kStart.begin(), kStart.end(), data->qpos);
    }
    scene.lay_out(full.get());
    std::array<double, kArmJoints> goal{};
    for (int i = 0; i < 2000; ++i) {
      if (i % 20 == 0) {
        for (std::size_t joint = 0; joint < kArmJoints; ++joint) {
          goal[joint] = kStart[joint] + random.uniform(-0.3, 0.3);
        }
      }
      for (int joint = 0; joint < kRobotJoints; ++joint) {
        const double target = joint < kArmJoints ? goal[static_cast<std::size_t>(joint)] : 0.02;
        const double force = 1000 * (target - alone->qpos[joint]) - 100 * alone->qvel[joint];
        alone->ctrl[joint] = std::clamp(force, -100.0, 100.0);
      }
      std::copy_n(alone->ctrl, kRobotJoints, full->ctrl);
      scene.apply_weights(full.get());
      mj_step(&scene.model.robot(), alone.get());
      mj_step(&scene.model.full(), full.get());
      REQUIRE(alone->nefc == 0);  // free of limits and contacts: see the next test
      REQUIRE(full->ncon >= 36);
      REQUIRE(same(alone->qpos, full->qpos, kRobotJoints));
      REQUIRE(same(alone->qvel, full->qvel, kRobotJoints));
    }
  }
}

// Where the robot itself has constraint rows the solver iterates on robot and cubes together, so
// that awake cubes change when it stops; by how little is measured here.
TEST_CASE("At a joint limit resting cubes change the robot in its last bits only", "[physics]") {
  const Compiled scene(9);
  const DataPtr alone = make_data(scene.model.robot());
  const DataPtr full = make_data(scene.model.full());
  for (mjData* data : {alone.get(), full.get()}) {
    std::copy(kStart.begin(), kStart.end(), data->qpos);
  }
  scene.lay_out(full.get());
  int limited = 0;
  double worst = 0;
  for (int i = 0; i < 1000; ++i) {
    for (mjData* data : {alone.get(), full.get()}) {
      for (int joint = 0; joint < kRobotJoints; ++joint) {
        double target = kStart[static_cast<std::size_t>(joint)];
        if (joint == 0) target += 0.3 * std::sin(0.02 * i);
        if (joint == 6) target = 3.5;    // beyond its limit
        if (joint == 7) target = -0.01;  // likewise
        const double force = 1000 * (target - data->qpos[joint]) - 100 * data->qvel[joint];
        data->ctrl[joint] = std::clamp(force, -100.0, 100.0);
      }
    }
    scene.apply_weights(full.get());
    mj_step(&scene.model.robot(), alone.get());
    mj_step(&scene.model.full(), full.get());
    limited += alone->nefc > 0 ? 1 : 0;
    for (int joint = 0; joint < kRobotJoints; ++joint) {
      worst = std::max(worst, std::abs(alone->qpos[joint] - full->qpos[joint]));
    }
  }
  CAPTURE(worst);
  CHECK(limited > 500);
  CHECK(worst < 1e-10);  // 4e-16 when this was written
}

}  // namespace
}  // namespace engram
