// `engram rollout`: its JSON, its hash and its counting.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "apps/digest.h"
#include "core/batch/scripted_policy.h"
#include "protocol/make/make.h"
#include "tests/apps/command.h"

namespace engram::test {
namespace {

constexpr const char* kId = "RememberColor3-VLA-v0";

ParsedJson rollout(const std::string& options) {
  return engram_command(std::string("rollout ") + kId + " --json " + options).json();
}

}  // namespace

TEST_CASE("rollout: exactly the documented fields", "[apps]") {
  const ParsedJson report = rollout("--num-envs 8 --steps 70 --threads 2");
  CHECK(keys_of(report) ==
        std::vector<std::string>{"id", "num_envs", "steps", "threads", "obs", "policy", "renderer",
                                 "rules", "env_steps_per_second", "physics_steps_per_second",
                                 "images_per_second", "episodes", "success_once", "mean_return",
                                 "unstable", "hash", "wall_seconds"});
  CHECK(report["id"] == kId);
  CHECK(report["num_envs"] == 8);
  CHECK(report["steps"] == 70);
  CHECK(report["threads"] == 2);
  CHECK(report["obs"] == "state");
  CHECK(report["policy"] == "random");
  CHECK(report["renderer"] == "none");
  CHECK(report["rules"] == "reference");
  CHECK(report["images_per_second"] == 0);
  CHECK(report["episodes"] == 16);
  CHECK(report["unstable"] == 0);
  CHECK(report["hash"].is_null());
  const double rate = report["env_steps_per_second"].get<double>();
  CHECK(report["physics_steps_per_second"].get<double>() == Approx(5 * rate));
  // Steps in which the next episodes begin count for nothing.
  CHECK(rate * report["wall_seconds"].get<double>() == Approx(8 * 68));
}

TEST_CASE("rollout: without a finished episode there is no rate of success", "[apps]") {
  const ParsedJson report = rollout("--num-envs 2 --steps 5");
  CHECK(report["episodes"] == 0);
  CHECK(report["success_once"].is_null());
  CHECK(report["mean_return"].is_null());
}

TEST_CASE("rollout: the hash does not depend on threads, but on the seed", "[apps]") {
  const std::string options = "--num-envs 16 --steps 40 --hash --seed ";
  const ParsedJson one = rollout(options + "5 --threads 1");
  CHECK(one["hash"].get<std::string>().size() == 16);
  CHECK(one["hash"] == rollout(options + "5 --threads 2")["hash"]);
  CHECK(one["hash"] != rollout(options + "6 --threads 1")["hash"]);
  CHECK(one["hash"] != rollout(options + "5 --threads 1 --pin target=1")["hash"]);
  CHECK(rollout(options + "18446744073709551615")["hash"].is_string());
}

TEST_CASE("rollout: images are counted and hashed", "[apps]") {
  const std::string options = "--obs rgb --num-envs 4 --steps 12 --hash";
  const ParsedJson report = rollout(options + " --threads 1");
  CHECK(report["obs"] == "rgb");
  CHECK(report["renderer"] == "cpu");
  CHECK(report["images_per_second"].get<double>() ==
        Approx(2 * report["env_steps_per_second"].get<double>()));
  CHECK(report["hash"] == rollout(options + " --threads 2")["hash"]);
  CHECK(report["hash"] != rollout("--num-envs 4 --steps 12 --hash")["hash"]);
}

TEST_CASE("rollout: the hash is that of the library's outputs", "[apps]") {
  const BatchOptions options{.num_envs = 4, .seed = 9, .threads = 1, .chunk = 3};
  const auto batch = make(kId, options);
  std::vector<float> actions(4 * static_cast<std::size_t>(batch->action_dim()));
  apps::Digest digest(4);
  batch->reset();
  digest.update(*batch);
  for (int step = 0; step < 30; ++step) {
    ScriptedPolicy(*batch, Policy::kRandom).act(actions);
    batch->step(actions);
    digest.update(*batch);
  }
  const ParsedJson report = rollout("--num-envs 4 --seed 9 --steps 30 --hash");
  CHECK(std::stoull(report["hash"].get<std::string>(), nullptr, 16) == digest.value());
}

TEST_CASE("rollout: as many episodes as asked for, in every auto-reset mode", "[apps]") {
  for (const char* mode : {"next-step", "same-step", "off"}) {
    INFO(mode);
    const ParsedJson report =
        rollout(std::string("--num-envs 4 --episodes 3 --policy oracle --auto-reset ") + mode);
    CHECK(report["episodes"] == 3);
    CHECK(report["success_once"] == 1.0);
    CHECK(report["steps"] == 25);
  }
  const ParsedJson several =
      rollout("--num-envs 4 --episodes 10 --policy zero --auto-reset same-step");
  CHECK(several["episodes"] == 10);
  CHECK(several["steps"] == 75);
  CHECK(rollout("--episodes 3 --policy zero")["num_envs"] == 3);
  require_refusal(std::string("rollout ") + kId + " --num-envs 4 --episodes 5 --auto-reset off", 2,
                  "up to 4 allowed");
}

TEST_CASE("rollout: --auto-reset off ends with the last episode", "[apps]") {
  const ParsedJson report = rollout("--num-envs 3 --steps 500 --policy zero --auto-reset off");
  CHECK(report["steps"] == 25);
  CHECK(report["episodes"] == 3);
}

TEST_CASE("rollout: options reach the simulation", "[apps]") {
  const std::string base = "--num-envs 4 --steps 20 --hash ";
  const ParsedJson plain = rollout(base);
  CHECK(plain["hash"] != rollout(base + "--no-freeze-cue")["hash"]);
  CHECK(plain["hash"] != rollout(base + "--rotation-sign 1")["hash"]);
  CHECK(plain["hash"] != rollout(base + "--reward sparse")["hash"]);
  CHECK(plain["hash"] != rollout(base + "--control-mode pd_joint_delta_pos")["hash"]);
  const ParsedJson ended =
      rollout("--num-envs 4 --episodes 4 --policy oracle --terminate-on-success");
  CHECK(ended["steps"].get<int>() < 25);
}

TEST_CASE("rollout: pins fix what episodes draw", "[apps]") {
  const std::string base = "--num-envs 4 --episodes 4 --policy oracle ";
  CHECK(rollout(base + "--pin cue_steps=5 --pin empty_steps=5")["success_once"] == 1.0);
  CHECK(rollout(base + "--pin target=2 --hash")["hash"] !=
        rollout(base + "--pin target=1 --hash")["hash"]);
  const std::string places = "--pin positions=-0.1,-0.15,-0.1,0,-0.1,0.15 ";
  const ParsedJson pinned = rollout(base + places + "--hash");
  CHECK(pinned["success_once"] == 1.0);
  CHECK(pinned["hash"] != rollout(base + "--hash")["hash"]);
  CHECK(pinned["hash"] == rollout(base + places + "--hash --threads 1")["hash"]);
}

TEST_CASE("rollout: shortcuts of the physics do not change outcomes", "[apps]") {
  const std::string base = "--num-envs 16 --episodes 16 --policy oracle ";
  CHECK(rollout(base + "--no-sleep")["success_once"] == rollout(base)["success_once"]);
}

TEST_CASE("rollout: text output", "[apps]") {
  const CommandResult result =
      engram_command(std::string("rollout ") + kId + " --num-envs 2 --steps 4");
  CHECK(result.code == 0);
  CHECK(result.err.empty());
  CHECK_THAT(result.out, Catch::Contains("env steps/s") && Catch::Contains("none finished"));
}

}  // namespace engram::test
