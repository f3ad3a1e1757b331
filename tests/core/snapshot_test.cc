#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "core/checksum.h"
#include "core/error.h"
#include "core/random.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::Bytes;
using test::env_bytes;
using test::make_env;

constexpr const char* kId = "RememberColor9-VLA-v0";

// The oracle's way to the target, then down onto it.
void press(VectorEnv& env) {
  std::vector<float> actions = test::act(env, Policy::kOracle);
  for (int i = 0; i < env.num_envs(); ++i) {
    if (env.state().elapsed[i] >= 18) actions[static_cast<std::size_t>(7 * i + 2)] = -0.5F;
  }
  env.step(actions);
}

// What one environment shows and remembers over the next steps.
std::vector<Bytes> future(VectorEnv& env, int index, int steps = 45) {
  std::vector<Bytes> history;
  for (int i = 0; i < steps; ++i) {
    press(env);
    history.push_back(env_bytes(env, index));
  }
  return history;
}

EnvOptions batch_of(int num_envs, std::uint64_t seed = 0) {
  EnvOptions options;
  options.num_envs = num_envs;
  options.seed = seed;
  return options;
}

TEST_CASE("An environment goes on bit for bit after it was restored", "[snapshot]") {
  RandomStream random(1, 0, 0);
  for (int round = 0; round < 8; ++round) {
    const auto env = make_env(kId, batch_of(3, static_cast<std::uint64_t>(10 * round)));
    env->reset();
    const int steps = random.integer(0, 40);
    for (int i = 0; i < steps; ++i) press(*env);
    const int index = random.integer(0, 2);
    const std::vector<std::byte> saved = env->save(index);
    const Bytes now = env_bytes(*env, index);
    const std::vector<Bytes> expected = future(*env, index);

    // Into the same slot, another slot, and a batch of another size and seed.
    env->restore(index, saved);
    CHECK(env_bytes(*env, index) == now);
    CHECK((future(*env, index) == expected));
    env->restore((index + 1) % 3, saved);
    CHECK((future(*env, (index + 1) % 3) == expected));
    const auto other = make_env(kId, batch_of(5, 999));
    other->reset();
    for (int i = 0; i < round; ++i) press(*other);
    other->restore(4, saved);
    CHECK((future(*other, 4) == expected));
  }
}

TEST_CASE("A snapshot in the middle of a contact goes on bit for bit", "[snapshot]") {
  EnvOptions options = batch_of(1, 3);
  options.sleep = GENERATE(true, false);
  const auto env = make_env(kId, options);
  env->reset();
  const auto in_contact = [&] {
    const double* force = env->state().finger_force.row(0);
    return std::any_of(force, force + 54, [](double v) { return v != 0; });
  };
  int contacts = 0;
  for (int i = 0; i < 24; ++i) {
    press(*env);
    if (!in_contact()) continue;
    ++contacts;
    const std::vector<std::byte> saved = env->save();
    const std::vector<Bytes> expected = future(*env, 0, 10);
    const auto fresh = make_env(kId, options);
    fresh->restore(saved);
    CHECK((future(*fresh, 0, 10) == expected));
    env->restore(saved);
  }
  CHECK(contacts >= 2);
}

// Under way, in flight, in a grasp: whatever the oracle is doing by then.
TEST_CASE("Every task goes on bit for bit from the middle of an episode", "[snapshot]") {
  const auto play = [](VectorEnv& env, int steps) {
    std::vector<Bytes> history;
    for (int i = 0; i < steps; ++i) {
      test::step(env, Policy::kOracle);
      history.push_back(test::batch_bytes(env));
    }
    return history;
  };
  for (const std::string& id : test::implemented_ids()) {
    const auto env = make_env(id, batch_of(2, 7));
    env->reset();
    for (const int steps : {2, 10, 10}) {
      play(*env, steps);
      const std::vector<std::byte> saved = env->save();
      const std::vector<Bytes> expected = play(*env, 6);
      const auto fresh = make_env(id, batch_of(2, 50));
      fresh->restore(saved);
      INFO(id);
      CHECK((play(*fresh, 6) == expected));
    }
  }
}

TEST_CASE("A reset leaves nothing of the episode before", "[reset]") {
  for (const std::string& id : test::implemented_ids()) {
    const auto fresh = make_env(id, batch_of(2, 30));
    fresh->reset();
    const auto used = make_env(id, batch_of(2, 7));
    used->reset();
    for (int i = 0; i < 22; ++i) test::step(*used, Policy::kOracle);
    const Bytes other = env_bytes(*used, 0);
    const std::vector<std::uint8_t> mask = {0, 1};
    const std::vector<std::uint64_t> seeds = {30, 31};
    used->reset({.mask = mask, .seeds = seeds});
    INFO(id);
    CHECK((env_bytes(*used, 1) == env_bytes(*fresh, 1)));
    CHECK((env_bytes(*used, 0) == other));
  }
}

TEST_CASE("A whole batch is restored into a fresh one, pins included", "[snapshot]") {
  EnvOptions options = batch_of(4);
  options.pins = {{"target", {6}}};
  const auto env = make_env(kId, options);
  env->reset();
  for (int i = 0; i < 20; ++i) press(*env);
  const std::vector<std::byte> saved = env->save();
  CHECK(env->save() == saved);
  const auto fresh = make_env(kId, batch_of(4, 50));  // never reset, without pins
  fresh->restore(saved);
  for (int i = 0; i < 40; ++i) {  // over an automatic reset
    press(*env);
    press(*fresh);
    REQUIRE(test::batch_bytes(*fresh) == test::batch_bytes(*env));
  }
  CHECK(*test::row<std::int32_t>(fresh->memory().find("target"), 0) == 6);
  CHECK(fresh->state().episode[0] > 0);
}

TEST_CASE("Restoring one environment leaves its neighbours alone", "[snapshot]") {
  const auto env = make_env(kId, batch_of(3));
  env->reset();
  const std::vector<std::byte> saved = env->save(0);
  for (int i = 0; i < 12; ++i) press(*env);
  const Bytes first = env_bytes(*env, 0);
  const Bytes last = env_bytes(*env, 2);
  env->restore(1, saved);
  CHECK(env_bytes(*env, 0) == first);
  CHECK(env_bytes(*env, 2) == last);
  CHECK(env->state().elapsed[1] == 0);
}

TEST_CASE("Snapshots that are damaged or foreign are refused and change nothing", "[snapshot]") {
  const auto env = make_env(kId, batch_of(2));
  env->reset();
  for (int i = 0; i < 5; ++i) press(*env);
  const std::vector<std::byte> good = env->save();
  const std::vector<std::byte> single = env->save(0);
  press(*env);
  const Bytes before = test::batch_bytes(*env);
  const auto refuse = [&](const std::vector<std::byte>& bytes, const char* why) {
    CHECK_THROWS_WITH(env->restore(bytes),
                      Catch::StartsWith("snapshot refused: ") && Catch::Contains(why));
    CHECK(test::batch_bytes(*env) == before);
  };

  RandomStream random(5, 0, 0);
  for (int i = 0; i < 200; ++i) {  // any damaged byte of the content
    std::vector<std::byte> bad = good;
    const int at = random.integer(32, static_cast<int>(bad.size()) - 1);
    bad[static_cast<std::size_t>(at)] ^=
        std::byte{static_cast<unsigned char>(random.integer(1, 255))};
    refuse(bad, "damaged");
  }
  for (std::size_t at = 0; at < 32; ++at) {  // any of the header
    std::vector<std::byte> bad = good;
    bad[at] ^= std::byte{0x10};
    refuse(bad, "");
  }
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{31}, std::size_t{32}, good.size() - 1}) {
    refuse({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)}, "");
  }
  std::vector<std::byte> longer = good;
  longer.push_back(std::byte{0});
  refuse(longer, "needed");
  refuse(single, "1 environments given, 2 needed");
  CHECK_THROWS_WITH(env->restore(0, good), Catch::Contains("2 environments given, 1 needed"));

  const auto foreign = make_env("RememberColor5-VLA-v0", batch_of(2));
  foreign->reset();
  refuse(foreign->save(), "another task");
  // The same columns, but another task.
  const auto lengthy = make_env("RememberColor9-Long-VLA-v0", batch_of(2));
  lengthy->reset();
  refuse(lengthy->save(), "another task");
  EnvOptions other_mode = batch_of(2);
  other_mode.control_mode = ControlMode::kPdEePose;  // the same columns here too
  const auto mode = make_env(kId, other_mode);
  mode->reset();
  refuse(mode->save(), "control mode");
  CHECK(test::batch_bytes(*env) == before);
  env->restore(good);  // the good one still is
  CHECK(env->save() == good);
}

// Bytes that somebody has made up, with a checksum that fits.
TEST_CASE("Snapshots of what no episode can have are refused", "[snapshot]") {
  const auto env = make_env(kId, batch_of(1));
  env->reset();
  const std::vector<std::byte> good = env->save();
  const Bytes before = test::batch_bytes(*env);
  const auto position = [&env](const char* column) {
    std::size_t at = 32;  // the header
    for (std::size_t i = 0; env->memory()[i].field->name != column; ++i) {
      const Field& field = *env->memory()[i].field;
      at += size_of(field.dtype) * static_cast<std::size_t>(field.width);
    }
    return at;
  };
  const auto with = [&good](std::size_t at, auto value) {
    std::vector<std::byte> bytes = good;
    std::memcpy(bytes.data() + at, &value, sizeof value);
    const std::uint64_t sum = checksum(std::span<const std::byte>(bytes).subspan(32));
    std::memcpy(bytes.data() + 24, &sum, sizeof sum);
    return bytes;
  };
  const auto refuse = [&](const std::vector<std::byte>& bytes, const char* why) {
    CHECK_THROWS_WITH(env->restore(bytes), Catch::Contains(why));
    CHECK_THROWS_WITH(env->restore(0, bytes), Catch::Contains(why));
    CHECK((test::batch_bytes(*env) == before));
  };
  for (const std::int32_t target : {-1, 9, 1'000'000, INT32_MIN, INT32_MAX}) {
    refuse(with(position("target"), target), "'target' has a value that no episode");
  }
  refuse(with(position("elapsed"), std::int32_t{-1}), "'elapsed'");
  refuse(with(position("elapsed"), env->info().horizon + 1), "'elapsed'");
  refuse(with(position("finished"), std::uint8_t{2}), "'finished'");
  refuse(with(position("prop_status"), std::uint8_t{3}), "'prop_status'");
  const std::size_t pins = 32 + env->memory().row_bytes();
  refuse(with(pins, ~std::uint64_t{0}), "snapshot refused");
  env->restore(with(position("target"), std::int32_t{8}));  // what one can have is taken
  CHECK(*test::row<std::int32_t>(env->memory().find("target"), 0) == 8);
}

TEST_CASE("Saving needs a reset and an environment of the batch", "[snapshot]") {
  const auto env = make_env(kId, batch_of(2));
  CHECK_THROWS_WITH(env->save(), Catch::Contains("before the first reset"));
  CHECK_THROWS_AS(env->save(0), Error);
  env->reset();
  const std::vector<std::byte> saved = env->save(0);
  CHECK_THROWS_WITH(env->save(2), Catch::Contains("environment 2 given, 0 to 1 allowed"));
  CHECK_THROWS_AS(env->restore(-1, saved), Error);
  const auto fresh = make_env(kId, batch_of(2));
  CHECK_THROWS_WITH(fresh->restore(0, saved), Catch::Contains("before the first reset"));
}

}  // namespace
}  // namespace engram
