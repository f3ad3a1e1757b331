// MuJoCo's own step as the physics of a batch.
#include "core/sim/mujoco_physics.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/batch/queries.h"
#include "core/batch/snapshot.h"
#include "core/scene/free_body.h"
#include "tests/env_helpers.h"

namespace engram::test {
namespace {

constexpr const char* kId = "RememberColor3-VLA-v0";

BatchOptions mujoco(int num_envs, std::uint64_t seed = 0) {
  BatchOptions options{.num_envs = num_envs, .seed = seed};
  options.physics = Physics::kMujoco;
  return options;
}

using History = std::vector<Bytes>;

// All that one environment remembers and shows after every step.
History play(Batch& batch, int env, int steps) {
  History history = {env_bytes(batch, env)};
  for (int i = 0; i < steps; ++i) {
    step(batch, Policy::kOracle);
    history.push_back(env_bytes(batch, env));
  }
  return history;
}

double success_rate(const char* id, int episodes) {
  BatchOptions options = mujoco(episodes, 4242424242);
  options.auto_reset = AutoReset::kOff;
  const auto batch = make_running(id, options);
  for (int i = 0; i < batch->horizon(); ++i) step(*batch, Policy::kOracle);
  CHECK(Queries(*batch).unstable_count() == 0);
  const auto* succeeded = row<std::uint8_t>(batch->output("success_once"), 0);
  return static_cast<double>(std::count(succeeded, succeeded + episodes, 1)) / episodes;
}

}  // namespace

// Tasks in which props are touched, pushed, gripped, turned, carried and caught.
TEST_CASE("MuJoCo's step: oracles succeed", "[mujoco_physics]") {
  for (const char* id :
       {"RememberColor3-VLA-v0", "ShellGameTouch-VLA-v0", "ShellGamePush-VLA-v0",
        "ShellGamePick-VLA-v0", "ShellGamePick-v0", "TakeItBack-VLA-v0", "RotateLenientPos-VLA-v0",
        "RotateStrictPos-VLA-v0", "InterceptMedium-VLA-v0", "InterceptGrabFast-VLA-v0"}) {
    INFO(id);
    CHECK(success_rate(id, 20) >= 0.95);
  }
}

TEST_CASE("MuJoCo's step: oracles succeed in all tasks", "[mujoco_physics][long]") {
  constexpr int kSteps = 20'000;
  for (const std::string& id : implemented_ids()) {
    INFO(id);
    const int episodes = std::clamp(kSteps / require_entry(id).horizon, 10, 50);
    CHECK(success_rate(id.c_str(), episodes) >= 0.9);
  }
}

TEST_CASE("MuJoCo's step: mjData share the memory of a step", "[mujoco_physics]") {
  for (const char* id : {"RememberColor9-VLA-v0", "RememberShapeAndColor5x3-VLA-v0"}) {
    INFO(id);
    const auto own = make_running(id, {.num_envs = 8});
    const auto batch = make_running(id, mujoco(8));
    for (int i = 0; i < 20; ++i) step(*batch, Policy::kOracle);
    const std::size_t bytes = Queries(*batch).bytes_per_env() - Queries(*own).bytes_per_env();
    CHECK(bytes > sizeof(mjData));
    CHECK(bytes < (mjVERSION_HEADER < 300 ? 100'000 : 2'000'000));  // newer ones have an arena
  }
}

TEST_CASE("MuJoCo's step: bits depend on neither threads, batch size, slot nor chunk",
          "[mujoco_physics][determinism]") {
  for (const char* id : {kId, "ShellGamePush-VLA-v0"}) {
    INFO(id);
    const auto alone = make_running(id, mujoco(1, 5));
    const History expected = play(*alone, 0, 40);
    BatchOptions options = mujoco(7);
    for (const int threads : {1, 3}) {
      options.threads = threads;
      options.chunk = threads;
      const auto batch = make_running(id, options);
      CHECK((play(*batch, 5, 40) == expected));
    }
  }
}

TEST_CASE("MuJoCo's step: an environment goes on bit for bit after it was restored",
          "[mujoco_physics][snapshot]") {
  const auto batch = make_running("ShellGamePush-VLA-v0", mujoco(2));
  play(*batch, 0, 25);
  const std::vector<std::byte> saved = Snapshotter(*batch).save(0);
  const History expected = play(*batch, 0, 15);
  const auto other = make_running("ShellGamePush-VLA-v0", mujoco(3, 77));
  play(*other, 0, 10);
  Snapshotter(*other).restore(2, saved);
  CHECK((play(*other, 2, 15) == expected));
}

TEST_CASE("Snapshots of one physics are refused by the other", "[mujoco_physics][snapshot]") {
  const auto own = make_running(kId, BatchOptions{});
  const auto other = make_running(kId, mujoco(1));
  CHECK_THROWS_WITH(Snapshotter(*own).restore(0, Snapshotter(*other).save(0)),
                    Catch::Contains("physics=mujoco"));
  CHECK_THROWS_WITH(Snapshotter(*other).restore(0, Snapshotter(*own).save(0)),
                    Catch::Contains("physics=mujoco"));
}

TEST_CASE("MuJoCo's silent reset is a diverged environment, and nothing is written",
          "[mujoco_physics]") {
  const auto batch = make_running(kId, mujoco(2));
  const State& state = batch->state();
  const bool log_before = std::filesystem::exists("MUJOCO_LOG.TXT");
  std::fill_n(state.qvel.row(1), kRobotJoints, 1e11);
  const std::vector<double> before(state.qpos.row(1), state.qpos.row(1) + kRobotJoints);
  batch->step(zeros(*batch));
  CHECK(batch->outputs().unstable[0] == 0);
  CHECK(batch->outputs().unstable[1] == 1);
  CHECK(Queries(*batch).unstable_count() == 1);
  CHECK(std::equal(before.begin(), before.end(), state.qpos.row(1)));
  CHECK(std::filesystem::exists("MUJOCO_LOG.TXT") == log_before);
  batch->step(zeros(*batch));  // a new episode
  batch->step(zeros(*batch));
  CHECK(batch->outputs().unstable[1] == 0);
}

TEST_CASE("MuJoCo's step: a peg that spins in the air gains no energy", "[mujoco_physics]") {
  const auto batch = make_running("RotateLenientPos-VLA-v0", mujoco(1));
  const State& state = batch->state();
  const double pos[3] = {0.1, 0.3, 0.5};
  const double quat[4] = {1, 0, 0, 0};
  state.place_prop(0, 0, pos, quat);
  const std::array<double, 6> velocity = {0, 0, 3, 60, 20, -5};
  std::copy(velocity.begin(), velocity.end(), state.prop_qvel_of(0, 0));
  const mjModel& model = BatchAccess::data(*batch).mujoco->model();
  const FreeBody peg(model, mj_name2id(&model, mjOBJ_BODY, "peg"));
  const auto momentum = [&]() -> Vec3 {
    const FreeBodyState now =
        peg.load(state.prop_pos_of(0, 0), state.prop_quat_of(0, 0), state.prop_qvel_of(0, 0));
    return peg.inv_inertia(now.quat).inverse() * now.angular;
  };
  const Vec3 before = momentum();
  for (int i = 0; i < 10; ++i) batch->step(zeros(*batch));
  REQUIRE(Queries(*batch).unstable_count() == 0);
  CHECK(state.prop_pos_of(0, 0)[2] > 0.5);  // no contact
  CHECK(momentum().norm() == Approx(before.norm()).epsilon(0.03));
}

TEST_CASE("A full buffer of MuJoCo is a diverged environment", "[mujoco_physics]") {
  const auto batch = make_running(kId, mujoco(1));
  const double pos[3] = {0.1, 0.3, 0.02};  // four contacts with the table
  const double quat[4] = {1, 0, 0, 0};
  batch->state().place_prop(0, 0, pos, quat);
#if mjVERSION_HEADER >= 300
  const_cast<mjData&>(Queries(*batch).mujoco_data(0)).narena = 4096;
#else
  const_cast<mjModel&>(BatchAccess::data(*batch).mujoco->model()).nconmax = 1;
#endif
  batch->step(zeros(*batch));
  CHECK(batch->outputs().unstable[0] == 1);
}

TEST_CASE("MuJoCo's step: a cube falls and rests, and a hidden one does not move",
          "[mujoco_physics]") {
  const auto batch = make_running(kId, mujoco(1));
  const State& state = batch->state();
  const double pos[3] = {0.1, 0.3, 0.1};
  const double quat[4] = {1, 0, 0, 0};
  state.place_prop(0, 0, pos, quat);
  state.hide_prop(0, 1, pos);
  for (int i = 0; i < 4; ++i) batch->step(zeros(*batch));
  if (state.status_of(0, 0) != PropStatus::kHidden) {
    CHECK(state.prop_pos_of(0, 0)[2] == Approx(0.02).margin(2e-4));
  }
  if (state.status_of(0, 1) == PropStatus::kHidden) CHECK(state.prop_qvel_of(0, 1)[2] == 0);
}

}  // namespace engram::test
