// Faults stay where they happen, and bad calls change nothing.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/batch/queries.h"
#include "core/batch/scripted_policy.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::env_bytes, test::make_env, test::make_running, test::zeros;

constexpr const char* kId = "RememberColor3-VLA-v0";
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Everything that a piece of code prints, by way of the file descriptors.
class Silence {
 public:
  Silence() {
    std::fflush(nullptr);
    file_ = std::tmpfile();
    for (int i = 0; i < 2; ++i) {
      saved_[i] = dup(i + 1);
      dup2(fileno(file_), i + 1);
    }
  }
  ~Silence() {
    restore();
    std::fclose(file_);
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

  // Bytes printed so far; output goes its usual way afterwards.
  long restore() {
    if (saved_[0] < 0) return 0;
    std::fflush(nullptr);
    for (int i = 0; i < 2; ++i) {
      dup2(saved_[i], i + 1);
      close(saved_[i]);
      saved_[i] = -1;
    }
    struct stat info {};
    fstat(fileno(file_), &info);
    return static_cast<long>(info.st_size);
  }

 private:
  std::FILE* file_ = nullptr;
  int saved_[2] = {-1, -1};
};

TEST_CASE("Physics that diverges ends that episode alone", "[fault]") {
  struct Fault {
    const char* what;
    std::function<void(const State&, int env)> inject;
  };
  const Fault faults[] = {
      {"nan position", [](const State& s, int env) { s.qpos.row(env)[2] = kNan; }},
      {"infinite position", [](const State& s, int env) { s.qpos.row(env)[7] = kInfinity; }},
      {"nan velocity", [](const State& s, int env) { s.qvel.row(env)[0] = kNan; }},
      {"huge velocity", [](const State& s, int env) { s.qvel.row(env)[6] = 1e30; }},
      {"huge position", [](const State& s, int env) { s.qpos.row(env)[1] = -1e200; }},
      {"nan cube",
       [](const State& s, int env) {
         s.prop_status.row(env)[0] = static_cast<std::uint8_t>(PropStatus::kAwake);
         s.prop_pos_of(env, 0)[1] = kNan;
       }},
      {"mad cube",
       [](const State& s, int env) {
         s.prop_status.row(env)[0] = static_cast<std::uint8_t>(PropStatus::kAwake);
         s.prop_qvel_of(env, 0)[2] = 1e40;
       }},
  };
  const bool sleep = GENERATE(true, false);
  const AutoReset auto_reset = GENERATE(AutoReset::kNextStep, AutoReset::kSameStep);
  for (const Fault& fault : faults) {
    BatchOptions options{.num_envs = 4};
    options.threads = 1;  // so that a fault could spread by way of the workspace
    options.sleep = sleep;
    options.auto_reset = auto_reset;
    const auto sound = make_env(kId, options);
    const auto batch = make_env(kId, options);
    sound->reset();
    batch->reset();
    for (int i = 0; i < 11; ++i) {
      test::step(*sound, Policy::kOracle);
      test::step(*batch, Policy::kOracle);
    }
    INFO(fault.what << ", sleep " << sleep);
    fault.inject(batch->state(), 1);
    const bool log_before = std::filesystem::exists("MUJOCO_LOG.TXT");
    Silence silence;
    batch->step(test::act(*sound, Policy::kOracle));
    const long printed = silence.restore();
    test::step(*sound, Policy::kOracle);
    CHECK(printed == 0);
    CHECK(std::filesystem::exists("MUJOCO_LOG.TXT") == log_before);

    CHECK(batch->outputs().unstable[1] == 1);
    CHECK(batch->outputs().truncated[1] == 1);
    CHECK(batch->outputs().terminated[1] == 0);
    CHECK(Queries(*batch).unstable_count() == 1);
    CHECK((batch->outputs().final_mask[1] != 0) == (auto_reset == AutoReset::kSameStep));
    for (const int i : {0, 2, 3}) CHECK(env_bytes(*batch, i) == env_bytes(*sound, i));

    for (int i = 0; i < 20; ++i) {
      const std::vector<float> actions = test::act(*sound, Policy::kOracle);
      batch->step(actions);
      sound->step(actions);
      for (const int k : {0, 2, 3}) REQUIRE(env_bytes(*batch, k) == env_bytes(*sound, k));
      REQUIRE(batch->outputs().unstable[1] == 0);
      for (const float value : batch->outputs().observation) REQUIRE(std::isfinite(value));
    }
    CHECK(Queries(*batch).unstable_count() == 1);
    CHECK(batch->state().episode[1] == 1);
  }
}

TEST_CASE("Actions that are not finite are refused whole", "[fault]") {
  const auto batch = make_running(kId, {.num_envs = 3});
  test::step(*batch, Policy::kRandom);
  const test::Bytes before = test::batch_bytes(*batch);
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
        -std::numeric_limits<float>::infinity()}) {
    std::vector<float> actions = zeros(*batch);
    actions[7 * 2 + 4] = bad;
    CHECK_THROWS_WITH(batch->step(actions),
                      Catch::Contains("environment 2, component 4") && Catch::Contains("finite"));
    CHECK(test::batch_bytes(*batch) == before);
  }
  for (const std::size_t length : {0u, 7u, 20u, 22u}) {
    CHECK_THROWS_WITH(batch->step(std::vector<float>(length)), Catch::Contains("21 needed"));
    std::vector<float> out(length);
    CHECK_THROWS_WITH(ScriptedPolicy(*batch, Policy::kZero).act(out), Catch::Contains("21 needed"));
  }
  CHECK(test::batch_bytes(*batch) == before);
  const float largest = std::numeric_limits<float>::max();
  batch->step(std::vector<float>(21, largest));  // finite, and clipped
  CHECK(Queries(*batch).unstable_count() == 0);
}

TEST_CASE("Absurd targets of absolute modes end an episode at worst", "[fault]") {
  for (const ControlMode mode :
       {ControlMode::kPdJointPos, ControlMode::kPdEePose, ControlMode::kPdJointPosVel}) {
    const auto batch = make_running(kId, {.control_mode = mode, .freeze_cue = false});
    std::vector<float> actions = zeros(*batch);
    std::fill(actions.begin(), actions.end(), std::numeric_limits<float>::max());
    for (int i = 0; i < 30; ++i) {
      batch->step(actions);
      if (batch->outputs().truncated[0] == 0) {
        for (const float value : batch->outputs().observation) REQUIRE(std::isfinite(value));
      }
    }
  }
}

TEST_CASE("Every registered task can be made, and an unknown one is refused", "[fault]") {
  for (const RegistryEntry& entry : registry()) {
    CHECK(make_task(entry.id)->info().id == entry.id);
  }
  try {
    make_task("RememberColour9-VLA-v0");
    FAIL("made");
  } catch (const Error& error) {
    CHECK(error.kind() == Error::kUnknownId);
    CHECK_THAT(error.what(), Catch::Contains("did you mean 'RememberColor9-VLA-v0'"));
  }
}

TEST_CASE("Nothing runs before the first reset", "[fault]") {
  const auto batch = make_env(kId);
  std::vector<float> actions = zeros(*batch);
  CHECK_THROWS_WITH(batch->step(actions), Catch::Contains("before the first reset"));
  CHECK_THROWS_WITH(ScriptedPolicy(*batch, Policy::kZero).act(actions),
                    Catch::Contains("before the first reset"));
}

TEST_CASE("A reset request of the wrong length changes nothing", "[fault]") {
  const auto batch = make_running(kId, {.num_envs = 2});
  const test::Bytes before = test::batch_bytes(*batch);
  const std::uint8_t mask[] = {1, 1, 1};
  const std::uint64_t seeds[] = {1};
  ResetRequest request;
  request.mask = mask;
  CHECK_THROWS_WITH(batch->reset(request), Catch::Contains("reset mask: 3 values given, 2 needed"));
  request = {};
  request.seeds = seeds;
  CHECK_THROWS_WITH(batch->reset(request),
                    Catch::Contains("reset seeds: 1 values given, 2 needed"));
  CHECK(test::batch_bytes(*batch) == before);
}

}  // namespace
}  // namespace engram
