// Free bodies against MuJoCo's own stages of a step.
#include "core/scene/free_body.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "core/math/random.h"
#include "core/scene/mujoco_handle.h"

namespace engram {
namespace {

// A body whose centre of mass and principal axes are not those of its frame.
ModelPtr free_body_model(const std::string& damping) {
  return compile_model(
      "<mujoco><option timestep='0.01' gravity='0 0 0'/><worldbody><body name='box'>"
      "<joint type='free' damping='" +
      damping +
      "'/><inertial pos='0.01 -0.02 0.03' quat='0.9 0.3 -0.2 0.1' mass='0.2' "
      "diaginertia='0.0003 0.0004 0.0006'/></body></worldbody></mujoco>");
}

void randomize(const mjModel& model, RandomStream& random, mjData& data) {
  for (int i = 0; i < 3; ++i) data.qpos[i] = random.uniform(-1, 1);
  for (int i = 3; i < 7; ++i) data.qpos[i] = random.normal();
  mju_normalize4(data.qpos + 3);
  for (int i = 0; i < model.nv; ++i) {
    data.qvel[i] = random.uniform(-3, 3);
    data.qfrc_applied[i] = random.uniform(-2, 2);
  }
}

double difference(const mjtNum* a, const mjtNum* b, int count) {
  double most = 0;
  for (int i = 0; i < count; ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

TEST_CASE("A free body moves as in mj_step, with damping and without", "[free_body]") {
  const ModelPtr model = free_body_model(GENERATE("0", "0.01"));
  const int body = mj_name2id(model.get(), mjOBJ_BODY, "box");
  REQUIRE(is_free_body(*model, body));
  CHECK_FALSE(is_free_body(*model, 0));
  const FreeBody free_body(*model, body);
  const DataPtr mine = make_data(*model);
  const DataPtr theirs = make_data(*model);
  RandomStream random(1, 0, 0);
  for (int round = 0; round < 200; ++round) {
    randomize(*model, random, *mine);
    std::copy_n(mine->qpos, model->nq, theirs->qpos);
    std::copy_n(mine->qvel, model->nv, theirs->qvel);
    std::copy_n(mine->qfrc_applied, model->nv, theirs->qfrc_applied);
    mj_step(model.get(), theirs.get());
    mj_kinematics(model.get(), mine.get());
    free_body.accelerate(*mine);
    std::copy_n(mine->qacc_smooth, model->nv, mine->qacc);
    free_body.integrate(*mine, model->opt.timestep);
    REQUIRE(difference(mine->qacc_smooth, theirs->qacc_smooth, model->nv) < 1e-9);
    REQUIRE(difference(mine->qvel, theirs->qvel, model->nv) < 1e-11);
    REQUIRE(difference(mine->qpos, theirs->qpos, model->nq) < 1e-13);
  }
}

TEST_CASE("The mass matrix of a free body is MuJoCo's", "[free_body]") {
  const ModelPtr model = free_body_model("0");
  const int body = mj_name2id(model.get(), mjOBJ_BODY, "box");
  const FreeBody free_body(*model, body);
  const DataPtr data = make_data(*model);
  RandomStream random(2, 0, 0);
  randomize(*model, random, *data);
  mj_forward(model.get(), data.get());
  std::array<double, 36> full{};
  mj_fullM(model.get(), full.data(), data->qM);
  const FreeBody::MassMatrix matrix = free_body.mass_matrix(*data);
  CHECK(difference(matrix.data(), full.data(), 36) < 1e-14);
}

TEST_CASE("A body is idle without velocity and applied force", "[free_body]") {
  const ModelPtr model = free_body_model("0");
  const FreeBody free_body(*model, mj_name2id(model.get(), mjOBJ_BODY, "box"));
  const DataPtr data = make_data(*model);
  CHECK(free_body.is_idle(*data));
  data->qvel[5] = 1e-300;
  CHECK_FALSE(free_body.is_idle(*data));
  data->qvel[5] = 0;
  data->qfrc_applied[2] = -1;
  CHECK_FALSE(free_body.is_idle(*data));
}

TEST_CASE("A rotation is integrated to the angle of its velocity", "[free_body]") {
  double quat[4] = {1, 0, 0, 0};
  for (int i = 0; i < 10; ++i) integrate_rotation(quat, {0, 0, 2}, 0.05);
  CHECK(quat[0] == Approx(std::cos(0.5)));
  CHECK(quat[3] == Approx(std::sin(0.5)));
  const std::vector<double> before(quat, quat + 4);
  integrate_rotation(quat, {0, 0, 0}, 0.05);
  CHECK(std::equal(before.begin(), before.end(), quat));
}

}  // namespace
}  // namespace engram
