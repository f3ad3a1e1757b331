// MuJoCo's own structures through the C and the C++ API.
#include <mujoco/mujoco.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "engram/engram.h"
#include "tests/api/c_api_fixture.h"

namespace engram {
namespace {

using test::BatchHandle, test::check_refused, test::default_options, test::kId, test::make_batch,
    test::make_running, test::outputs_of, test::step_by;

engram_options mujoco_options(int num_envs = 3) {
  engram_options options = default_options(num_envs);
  options.physics = ENGRAM_PHYSICS_MUJOCO;
  return options;
}

const mjModel* model_of(const BatchHandle& batch, int index = 0) {
  const mjModel* model = nullptr;
  REQUIRE(engram_mujoco_model(batch.get(), index, &model) == ENGRAM_OK);
  return model;
}

const mjData* data_of(const BatchHandle& batch, int index) {
  const mjData* data = nullptr;
  REQUIRE(engram_mujoco_data(batch.get(), index, &data) == ENGRAM_OK);
  return data;
}

}  // namespace

TEST_CASE("C API: MuJoCo's data are the present state of each environment",
          "[c_api][mujoco_physics]") {
  const BatchHandle batch = make_running(mujoco_options());
  const mjModel* model = model_of(batch);
  const mjData* first = data_of(batch, 0);
  CHECK(first->time == 0);
  CHECK(first != data_of(batch, 2));
  for (int i = 0; i < 5; ++i) step_by(batch, ENGRAM_POLICY_ORACLE);
  CHECK(data_of(batch, 0) == first);  // the address stays
  CHECK(first->time == Approx(0.25));

  std::vector<float> qpos(9 * 3);
  std::vector<float> tcp(7 * 3);
  REQUIRE(engram_robot_state(batch.get(), qpos.data(), nullptr, tcp.data()) == ENGRAM_OK);
  const int hand = mj_name2id(model, mjOBJ_BODY, "leftfinger");
  for (int env = 0; env < 3; ++env) {
    const mjData* data = data_of(batch, env);
    for (int i = 0; i < 9; ++i) {
      CHECK(static_cast<float>(data->qpos[i]) == qpos[static_cast<std::size_t>(9 * env + i)]);
    }
    // The fingers of mjData are beside the TCP: positions are those of the present qpos.
    double distance = 0;
    for (int i = 0; i < 3; ++i) {
      distance +=
          std::pow(data->xpos[3 * hand + i] - tcp[static_cast<std::size_t>(7 * env + i)], 2);
    }
    CHECK(std::sqrt(distance) < 0.07);
  }
}

TEST_CASE("C API: steps do not depend on whether MuJoCo's data are asked for",
          "[c_api][mujoco_physics][determinism]") {
  const BatchHandle asked = make_running(mujoco_options());
  const BatchHandle other = make_running(mujoco_options());
  for (int i = 0; i < 30; ++i) {
    step_by(asked, ENGRAM_POLICY_ORACLE);
    step_by(other, ENGRAM_POLICY_ORACLE);
    if (i % 3 != 0) data_of(asked, i % 2);
  }
  CHECK(outputs_of(asked) == outputs_of(other));
}

TEST_CASE("C API: MuJoCo's structures are refused where there are none",
          "[c_api][mujoco_physics]") {
  const mjModel* model = nullptr;
  const mjData* data = nullptr;
  const BatchHandle own = make_running();
  check_refused(engram_mujoco_model(own.get(), 0, &model), ENGRAM_INVALID_ARGUMENT,
                "physics 'engram' given, one with physics 'mujoco' needed");
  check_refused(engram_mujoco_data(own.get(), 0, &data), ENGRAM_INVALID_ARGUMENT,
                "physics 'mujoco' needed");
  const BatchHandle batch = make_batch(mujoco_options());
  data = own ? reinterpret_cast<const mjData*>(&model) : nullptr;
  check_refused(engram_mujoco_data(batch.get(), 0, &data), ENGRAM_BAD_STATE, "reset");
  CHECK(data == nullptr);
  CHECK(engram_mujoco_model(batch.get(), 0, &model) == ENGRAM_OK);
  CHECK(model != nullptr);
  check_refused(engram_mujoco_model(batch.get(), 3, &model), ENGRAM_INVALID_ARGUMENT, "3");
  CHECK(model == nullptr);
  check_refused(engram_mujoco_model(batch.get(), 0, nullptr), ENGRAM_INVALID_ARGUMENT, "model");
  check_refused(engram_mujoco_data(batch.get(), 0, nullptr), ENGRAM_INVALID_ARGUMENT, "data");
}

TEST_CASE("C++ API: each task of a batch has a model of MuJoCo's", "[cpp_api][mujoco_physics]") {
  EnvOptions options;
  options.physics = v0::Physics::kMujoco;
  VectorEnv envs =
      make_group({{"RememberColor3-VLA-v0", 2}, {"ShellGameTouch-VLA-v0", 1}}, options);
  envs.reset();
  CHECK(envs.mujoco_model(0) == envs.mujoco_model(1));
  CHECK(envs.mujoco_model(0) != envs.mujoco_model(2));
  CHECK(envs.mujoco_data(0) != envs.mujoco_data(1));
  CHECK(envs.mujoco_data(2)->qpos[0] == Approx(envs.mujoco_data(0)->qpos[0]).margin(0.1));
  CHECK(mujoco_version() == mj_versionString());
  CHECK_THROWS_AS(make(kId).mujoco_model(), v0::Error);
}

}  // namespace engram
