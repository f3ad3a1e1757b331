// The shell games in motion: snapshots in the middle of a swap, robots in the way of mugs, mugs
// that are pushed, picked up and put back.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "core/batch/snapshot.h"
#include "mjcf/mug.h"
#include "tasks/common/tcp_servo.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using Eigen::Vector3d, test::make_env, test::make_running, test::row;

Vector3d pos(const Batch& batch, int prop, int index = 0) {
  return Eigen::Map<Vector3d>(batch.state().prop_pos_of(index, prop));
}
Vector3d tcp(const Batch& batch) { return Eigen::Map<Vector3d>(batch.state().tcp_pos.row(0)); }

// One step of the tool towards a point.
void move(Batch& batch, const Vector3d& goal, double gripper) {
  std::vector<float> action(7);
  tasks::servo_tcp(batch.state(), 0, goal, tasks::kToolDown, gripper, action.data());
  batch.step(action);
}

TEST_CASE("A snapshot of a shell game goes on bit for bit, in the middle of a swap too",
          "[shell][snapshot]") {
  for (const RegistryEntry& entry : registry()) {
    if (entry.family.substr(0, 9) != "ShellGame") continue;
    INFO(entry.id);
    BatchOptions options{
        .num_envs = 2, .control_mode = ControlMode::kPdEeDeltaPose, .freeze_cue = false};
    const int cue = entry.split == Split::kMedium ? 10 : entry.split == Split::kRl ? 5 : 3;
    options.pins = {{"cue_steps", {static_cast<double>(cue)}}};
    const auto batch = make_running(entry.id, options);
    // Down to where the mugs pass, so that contacts are saved as well.
    const auto disturb = [](Batch& each) {
      std::vector<float> actions(14);
      for (int i = 0; i < 2; ++i) {
        const Vector3d goal(-0.02, 0.1, 0.06);
        tasks::servo_tcp(each.state(), i, goal, tasks::kToolDown, 0, actions.data() + 7 * i);
      }
      each.step(actions);
    };
    const auto other = make_env(entry.id, options);
    const auto twin = make_env(entry.id, options);
    other->reset();
    twin->reset();
    for (int t = 0; t < 26; ++t) {
      if (t % 3 == 0) {
        const std::vector<std::byte> saved = Snapshotter(*batch).save(1);
        Snapshotter(*other).restore(0, saved);
        Snapshotter(*twin).restore(1, saved);
      }
      // The original and two copies, in other slots and batches.
      for (Batch* each : {batch.get(), other.get(), twin.get()}) disturb(*each);
      REQUIRE(test::env_bytes(*other, 0) == test::env_bytes(*batch, 1));
      REQUIRE(test::env_bytes(*twin, 1) == test::env_bytes(*batch, 1));
    }
  }
}

TEST_CASE("A shell game that is reset equals a fresh one", "[shell]") {
  for (const RegistryEntry& entry : registry()) {
    if (entry.family.substr(0, 9) != "ShellGame") continue;
    INFO(entry.id);
    BatchOptions options{.num_envs = 2};
    const auto used = make_running(entry.id, options);
    for (int i = 0; i < 50; ++i) test::step(*used, Policy::kOracle);
    const std::vector<std::uint64_t> seeds = {70, 71};
    used->reset({.mask = {}, .seeds = seeds, .pins = nullptr});
    options.seed = 70;
    const auto fresh = make_running(entry.id, options);
    for (int i = 0; i < 12; ++i) {
      REQUIRE(test::batch_bytes(*used) == test::batch_bytes(*fresh));
      test::step(*used, Policy::kOracle);
      test::step(*fresh, Policy::kOracle);
    }
  }
}

// The hand waits where mugs come by at up to four metres a second.
TEST_CASE("Mugs that meet the robot nudge it and go on their way", "[shell]") {
  for (const double height : {0.02, 0.06, 0.10}) {
    const BatchOptions options{
        .pins = {{"base", {0.0, 0.0}},
                 {"cue_steps", {100}},
                 {"shuffle_steps", {100}},
                 {"num_swaps", {15}},
                 {"cup_with_ball_number", {0}},
                 {"swap_pairs", {1, 0, 2, 1, 1, 0, 0, 2, 1, 0, 2, 2, 1, 1, 0}}}};
    const auto batch = make_env("ShellGameShuffleTouch-Long-VLA-v0", options);
    const auto free = make_env("ShellGameShuffleTouch-Long-VLA-v0", options);
    batch->reset();
    free->reset();
    double fastest = 0;
    double farthest = 0;
    for (int t = 0; t < 260; ++t) {
      const Vector3d spot(0.1, 0.1, height);
      move(*batch, spot, -0.6);
      test::step(*free, Policy::kZero);
      if (t < 60) continue;
      const double* velocity = batch->state().qvel.row(0);
      for (int i = 0; i < kRobotJoints; ++i) fastest = std::max(fastest, std::abs(velocity[i]));
      farthest = std::max(farthest, (tcp(*batch) - spot).norm());
      for (int mug = 0; mug < 3; ++mug) CHECK(pos(*batch, mug) == pos(*free, mug));
      CHECK(batch->outputs().unstable[0] == 0);
    }
    INFO("height " << height << ": TCP strays " << farthest << " m, joints reach " << fastest);
    CHECK(farthest > 1e-4);  // they did meet
    CHECK(farthest < 0.12);
    CHECK(fastest < 2);
  }
}

TEST_CASE("Mugs that are put back cannot be carried away", "[shell]") {
  const auto batch =
      make_running("ShellGameColorLampTouch-VLA-v0",
                   {.freeze_cue = false, .pins = {{"base", {0.0, 0.0}}, {"cue_steps", {1}}}});
  double slowest = 1;
  for (int t = 1; t < 30; ++t) {
    const double before = tcp(*batch).x();
    move(*batch, t < 16 ? Vector3d(-0.15, 0, 0.06) : Vector3d(0.15, 0, 0.06), -0.6);
    if (t > 18) slowest = std::min(slowest, tcp(*batch).x() - before);
    CHECK((pos(*batch, 1) - Vector3d(0, 0, mjcf::kMugRestingHeight)).norm() < 1e-12);
    CHECK(batch->outputs().unstable[0] == 0);
  }
  CHECK(tcp(*batch).x() > 0);  // through the mug, which gives way and comes back
  CHECK(slowest < 0.03);
}

TEST_CASE("Pushed and lifted mugs stay whole: no sinking, no flying", "[shell]") {
  for (const char* id : {"ShellGamePush-VLA-v0", "ShellGamePick-VLA-v0"}) {
    const BatchOptions options{
        .num_envs = 20, .auto_reset = AutoReset::kOff, .terminate_on_success = false};
    const auto batch = make_running(id, options);
    std::vector<Eigen::Quaterniond> upright;
    const auto quat = [&](int mug, int i) {
      const double* q = batch->state().prop_quat_of(i, mug);
      return Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
    };
    for (int i = 0; i < options.num_envs; ++i) upright.push_back(quat(0, i));
    int lifted = 0;
    int pushed = 0;
    for (int t = 1; t <= 30; ++t) {
      test::step(*batch, Policy::kOracle);
      for (int i = 0; i < options.num_envs; ++i) {
        if (t < *row<std::int32_t>(test::memory_of(*batch).find("cue_steps"), i)) continue;
        for (int mug = 0; mug < 3; ++mug) {
          CHECK(pos(*batch, mug, i).z() > mjcf::kMugRestingHeight - 0.003);
          CHECK(pos(*batch, mug, i).z() < 0.2);
        }
      }
    }
    for (int i = 0; i < options.num_envs; ++i) {
      const int cup = *row<std::int32_t>(test::memory_of(*batch).find("cup_with_ball_number"), i);
      const double* base = row<double>(test::memory_of(*batch).find("base"), i);
      lifted += pos(*batch, cup, i).z() > mjcf::kMugRestingHeight + 0.012 ? 1 : 0;
      pushed += pos(*batch, cup, i).x() > base[0] + 0.03 ? 1 : 0;
      if (std::string_view(id) != "ShellGamePick-VLA-v0") continue;
      // Reward, observation and a real grasp agree.
      if (*row<std::uint8_t>(batch->output("is_grasped"), i) == 0) continue;
      const Eigen::Quaterniond turned =
          quat(cup, i) * upright[static_cast<std::size_t>(i)].conjugate();
      const Vector3d handle = pos(*batch, cup, i) + turned * Vector3d(-0.045, 0.043, 0);
      CHECK((handle - Eigen::Map<Vector3d>(batch->state().tcp_pos.row(i))).norm() < 0.04);
    }
    INFO(id);
    CHECK((std::string_view(id) == "ShellGamePick-VLA-v0" ? lifted : pushed) >= 18);
  }
}

}  // namespace
}  // namespace engram
