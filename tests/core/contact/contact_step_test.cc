// contact_step: free props against all of MuJoCo's stages; the robot among contacts; props that
// touch nothing have no influence.
#include "core/contact/contact_step.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

#include "core/contact/broad_phase.h"
#include "core/contact/coulomb_sliding.h"
#include "core/math/random.h"
#include "core/scene/physics_model.h"
#include "mjcf/ball.h"
#include "mjcf/object_shapes.h"
#include "mjcf/scene.h"
#include "tasks/common/task_info.h"

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
  explicit Compiled(const mjcf::Scene& scene) : source(tasks::scene_source(scene)), model(source) {
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

  SceneSpec source;
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
RobotParams no_drives(const PhysicsModel& model) {
  RobotParams params = model.robot_params();
  params.drive = {};
  return params;
}

// Applies Coulomb sliding to MuJoCo's own reference accelerations.
void apply_sliding(const SceneModel& scene, mjData* d, ContactConstraints& rows) {
  const std::vector<double> theirs(d->efc_aref, d->efc_aref + d->nefc);
  rows.build(scene, *d, {});
  const std::vector<double> before(d->efc_aref, d->efc_aref + d->nefc);
  apply_coulomb_sliding(scene, *d, rows);
  for (std::size_t i = 0; i < theirs.size(); ++i) {
    if (d->efc_aref[i] == before[i]) d->efc_aref[i] = theirs[i];
  }
}

// All stages of mj_step, with what the engine does to contacts in between.
void step_in_full(const SceneModel& scene, mjData* d, ContactConstraints& rows) {
  const mjModel* m = scene.model.get();
  mj_kinematics(m, d);
  mj_comPos(m, d);
  mj_camlight(m, d);
  mj_tendon(m, d);
  mj_crb(m, d);
  mj_factorM(m, d);
  mj_comVel(m, d);
  mj_collision(m, d);
  filter_contacts(*m, *d);
  mj_makeConstraint(m, d);
  mj_transmission(m, d);
  mj_fwdVelocity(m, d);
  mj_fwdActuation(m, d);
  mj_fwdAcceleration(m, d);
  apply_sliding(scene, d, rows);
  mj_fwdConstraint(m, d);
  mj_Euler(m, d);
}

// With a solver that goes on until nothing gets better.
SceneModel compile_exact(const Compiled& compiled) {
  std::vector<int> all(compiled.dof.size());
  std::iota(all.begin(), all.end(), 0);
  SceneModel scene = compile_scene(compiled.source, all, RobotDetail::kCollision);
  scene.model->opt.tolerance = 1e-15;
  return scene;
}

// Two data of a model, one stepped by MuJoCo's stages, the other by contact_step, from the
// same state every time: heaps are chaotic. The robot is at rest and out of reach.
struct Twins {
  explicit Twins(const Compiled& compiled)
      : scene(compiled),
        exact(compile_exact(compiled)),
        model(*exact.model),
        broad_phase(model),
        params(no_drives(compiled.model)),
        robot(params, {}),
        workspace({&exact, 1}),
        mine(make_data(model)),
        theirs(make_data(model)) {
    for (mjData* data : {mine.get(), theirs.get()}) {
      std::copy(kStart.begin(), kStart.end(), data->qpos);
    }
  }

  void step() {
    scene.apply_weights(theirs.get());
    std::copy_n(theirs->qfrc_applied, model.nv, mine->qfrc_applied);
    step_in_full(exact, theirs.get(), workspace.rows);
    robot.begin(scene.model.robot_model(), mine->qpos, mine->qvel);
    robot.run({});
    // By MuJoCo, too: its contacts of curved shapes jump with the last digits of poses.
    mj_kinematics(&model, mine.get());
    contact_step({&exact, broad_phase.near_pairs(*mine)}, mine.get(), robot, contact_force,
                 workspace);
    contacts += mine->ncon;
  }
  // Largest difference of velocities, m/s, rad/s, and of positions divided by the timestep.
  double difference() const {
    double most = 0;
    for (int i = kRobotJoints; i < model.nv; ++i) {
      most = std::max(most, std::abs(mine->qvel[i] - theirs->qvel[i]));
    }
    for (int i = kRobotJoints; i < model.nq; ++i) {
      most = std::max(most, std::abs(mine->qpos[i] - theirs->qpos[i]) / model.opt.timestep);
    }
    return most;
  }
  void follow() const {
    std::copy_n(mine->qpos, model.nq, theirs->qpos);
    std::copy_n(mine->qvel, model.nv, theirs->qvel);
    std::copy_n(mine->qacc_warmstart, model.nv, theirs->qacc_warmstart);
  }

  const Compiled& scene;
  SceneModel exact;
  const mjModel& model;
  BroadPhase broad_phase;
  RobotParams params;
  RobotStep robot;
  ContactWorkspace workspace;
  JointArray contact_force{};
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
    double most = 0;
    for (int i = 0; i < steps; ++i) {
      twins.step();
      most = std::max(most, twins.difference());
      twins.follow();
    }
    // 5e-11 were seen, in collisions at thousands of m/s^2.
    CHECK(most < 1e-10);
    CHECK(twins.contacts > contacts_per_step * steps);
  }
}

TEST_CASE("The contact step equals the full one with falling and colliding cubes", "[physics]") {
  check_heap(Compiled(9), 1000);
}

TEST_CASE("The contact step equals the full one with falling and colliding shapes", "[physics]") {
  check_heap(Compiled(nine_shapes()), 300);
}

// Motion is not chaotic here, so that the two may diverge.
TEST_CASE("Cubes that slide and come to rest stay where MuJoCo's stages take them", "[physics]") {
  const Compiled scene(9);
  Twins twins(scene);
  RandomStream random(1, 1, 0);
  for (std::size_t i = 0; i < scene.qpos.size(); ++i) {
    const double velocity[6] = {random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), 0, 0, 0,
                                random.uniform(-1, 1)};
    for (mjData* data : {twins.mine.get(), twins.theirs.get()}) {
      scene.lay_out(data);
      std::copy_n(velocity, 6, data->qvel + scene.dof[i]);
    }
  }
  double most = 0;
  for (int i = 0; i < 500; ++i) {
    twins.step();
    most = std::max(most, twins.difference());
  }
  CHECK(most < 1e-9);
  CHECK(twins.contacts > 10'000);
}

TEST_CASE("The contact step equals the full one with balls, whose rolling is damped", "[physics]") {
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
        chain(compiled.model.robot_model()),
        workspace(compiled.model.scenes()),
        data(make_data(*scene.model)) {
    scene.kinematics.pose_fixed(*data);
    std::copy(kStart.begin(), kStart.end(), data->qpos);
  }
  void step(const RobotParams& params, const DriveTarget& drive) {
    RobotStep robot(params, drive);
    robot.begin(chain, data->qpos, data->qvel);
    robot.run({});
    scene.kinematics.pose(pose_at(chain, data->qpos), *data);
    contact_step({&scene, scene.model.get()}, data.get(), robot, contact_force, workspace);
  }

  const SceneModel& scene;
  const RobotModel& chain;
  ContactWorkspace workspace;
  JointArray contact_force{};
  DataPtr data;
};

// Precondition of stepping the robot alone. Joints meet their limits here.
TEST_CASE("The robot moves the same with resting cubes in the scene and without", "[physics]") {
  const Compiled scene(9);
  const RobotParams& params = scene.model.robot_params();
  int at_limits = 0;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    RandomStream random(seed, 2, 0);
    Driven alone(scene, PhysicsModel::kDynamicsScene);
    Driven full(scene, scene.model.full_scene());
    scene.lay_out(full.data.get());
    DriveTarget drive;
    for (int i = 0; i < 2000; ++i) {
      if (i % 20 == 0) {
        for (std::size_t joint = 0; joint < kRobotJoints; ++joint) {
          drive.qpos[joint] = kStart[joint] + random.uniform(-0.3, 0.3);
        }
        drive.qpos[6] = 3.5;
      }
      scene.apply_weights(full.data.get());
      alone.step(params, drive);
      full.step(params, drive);
      at_limits += alone.data->qpos[6] >= params.upper[6] ? 1 : 0;
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
  Driven alone(scene, PhysicsModel::kDynamicsScene);
  Driven touching(scene, scene.model.full_scene());
  mj_kinematics(touching.scene.model.get(), touching.data.get());
  const int tip = mj_name2id(touching.scene.model.get(), mjOBJ_BODY, "leftfinger");
  double* cube = touching.data->qpos + scene.qpos[0];
  std::copy_n(touching.data->xpos + 3 * tip, 3, cube);
  cube[2] -= 0.045 + 0.0095 + 0.02 - 1e-6;  // just below a finger
  DriveTarget up;
  std::copy(kStart.begin(), kStart.end(), up.qpos.begin());
  up.qpos[1] -= 0.3;
  for (mjData* data : {alone.data.get(), touching.data.get()}) data->qvel[1] = -1;
  scene.apply_weights(touching.data.get());
  alone.step(scene.model.robot_params(), up);
  touching.step(scene.model.robot_params(), up);
  CHECK(touching.data->ncon > 0);
  CHECK(same(alone.data->qpos, touching.data->qpos, kRobotJoints));
  CHECK(same(alone.data->qvel, touching.data->qvel, kRobotJoints));
}

}  // namespace
}  // namespace engram
