#include "protocol/datasets/recorder.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "core/batch/scripted_policy.h"
#include "protocol/datasets/npz.h"
#include "protocol/io/files.h"
#include "protocol/make/rows.h"
#include "tests/tasks/benchmark_table.h"
#include "tests/temporary_folder.h"

namespace engram::test {

namespace fs = std::filesystem;

TEST_CASE("Demonstrations: rules of the families", "[demonstrations]") {
  int batched = 0;
  int planned = 0;
  for (const test::BenchmarkRow& row : test::benchmark()) {
    const RegistryEntry& entry = require_entry(row[0]);
    const CollectionRule rule = collection_rule(entry);
    if (rule.min_steps == 0) {
      ++planned;
      CHECK(rule.batch == 1);
      continue;
    }
    ++batched;
    CHECK(rule.min_steps == 10);
    CHECK(rule.batch == (entry.family == "ShellGamePick" ? 1 : 10));
    // The rollout limits of the batched families are their horizons.
    CHECK(entry.horizon <= 90);
  }
  CHECK(batched == 35);
  CHECK(planned == 62);
  // A user's own task: every episode counts, however short it is.
  RegistryEntry own = require_entry("RememberColor3-VLA-v0");
  own.id = own.base = "MyTask-v0";
  CHECK(collection_rule(own).batch == 1);
  CHECK(collection_rule(own).min_steps == 0);
}

TEST_CASE("Demonstrations: a recorded episode can be replayed", "[demonstrations]") {
  const std::pair<const char*, ControlMode> cases[] = {
      {"RememberColor3-VLA-v0", ControlMode::kPdEeDeltaPose},
      {"ShellGamePush-VLA-v0", ControlMode::kPdEeDeltaPose},
      {"RotateStrictPos-VLA-v0", ControlMode::kPdEeDeltaPose},
      {"ShellGamePush-VLA-v0", ControlMode::kPdJointPos},
      {"RotateStrictPos-VLA-v0", ControlMode::kPdJointDeltaPos}};
  for (const auto& [id, mode] : cases) {
    INFO(id << " " << name_of(mode));
    const std::size_t dim = mode == ControlMode::kPdEeDeltaPose ? 7 : 8;
    constexpr std::uint64_t kSeed = 4'242'424'242'424;
    MakeOptions options = demonstration_options();
    options.num_envs = 2;
    options.threads = 1;
    options.control_mode = mode;
    options.joint_proprio = dim == 8;
    const auto batch = make(id, options);
    const std::vector<std::uint64_t> seeds = {kSeed - 1, kSeed};
    batch->reset({.mask = {}, .seeds = seeds, .pins = nullptr});
    DemonstrationRecorder recorder;
    recorder.start(*batch, 1);
    std::vector<float> actions(2 * dim);
    while ((batch->outputs().terminated[1] | batch->outputs().truncated[1]) == 0) {
      ScriptedPolicy(*batch, Policy::kOracle).act(actions);
      recorder.before_step(*batch, 1, std::span(actions).subspan(dim));
      batch->step(actions);
      recorder.after_step(*batch, 1);
    }
    const Demonstration demonstration = recorder.finish();
    REQUIRE(demonstration.success);
    REQUIRE(demonstration.length > 5);

    const TemporaryFolder folder;
    const fs::path path = folder.path() / "a.npz";
    write_file(path, demonstration.file);
    const NpzFile file(path);
    const std::int64_t steps = demonstration.length;
    CHECK(file.scalar<std::int64_t>("episode_seed", NpyType::kInt64) == kSeed);
    CHECK(file.scalar<std::int32_t>("episode_length", NpyType::kInt32) == steps);
    CHECK(file.scalar<bool>("success_once", NpyType::kBool));
    const std::int64_t frames[] = {steps, 128, 128, 6};
    const std::int64_t rows[] = {steps, static_cast<std::int64_t>(dim)};
    const std::int64_t singles[] = {steps};
    const auto rgb = file.read("rgb", NpyType::kUint8, frames);
    const auto proprio = file.read("proprio", NpyType::kFloat32, rows);
    const auto stored = file.read("action", NpyType::kFloat32, rows);
    const auto reward = file.read("reward", NpyType::kFloat32, singles);
    const auto success = file.read("success", NpyType::kInt32, singles);
    CHECK(success == file.read("done", NpyType::kInt32, singles));

    // A fresh environment of the library's defaults has the same observations.
    MakeOptions fresh;
    fresh.seed = kSeed;
    fresh.threads = 1;
    fresh.obs_mode = ObsMode::kRgb;
    fresh.control_mode = mode;
    fresh.joint_proprio = dim == 8;
    const auto again = make(id, fresh);
    again->reset();
    bool equal = true;
    double sum = 0;
    std::vector<float> action(dim);
    for (std::size_t t = 0; t < static_cast<std::size_t>(steps); ++t) {
      const auto same = [t](const auto& shown, const std::vector<std::byte>& all) {
        const auto bytes = std::as_bytes(shown);
        return std::memcmp(bytes.data(), all.data() + t * bytes.size(), bytes.size()) == 0;
      };
      equal = equal && same(again->images().rgb, rgb) && same(again->outputs().proprio, proprio);
      std::memcpy(action.data(), stored.data() + t * 4 * dim, 4 * dim);
      const ActionSpace& space = again->action_space();
      for (std::size_t i = 0; i < dim; ++i) {
        CHECK((action[i] >= space.low[i] && action[i] <= space.high[i]));
      }
      again->step(action);
      equal = equal && same(again->outputs().reward, reward);
      CHECK((again->outputs().success[0] != 0) == (t + 1 == static_cast<std::size_t>(steps)));
      std::int32_t stored_success = 0;
      std::memcpy(&stored_success, success.data() + t * 4, 4);
      CHECK(stored_success == again->outputs().success[0]);
      sum += static_cast<double>(again->outputs().reward[0]);
    }
    CHECK(equal);
    CHECK(sum == demonstration.reward_sum);

    ByteWriter out;
    demonstration.pack(out);
    ByteReader in(out.bytes());
    const Demonstration unpacked = Demonstration::unpack(in);
    CHECK(unpacked.file == demonstration.file);
    CHECK(unpacked.length == demonstration.length);
    CHECK(in.rest().empty());
  }
}

TEST_CASE("Demonstrations: rows of state or objects, before each action", "[demonstrations]") {
  for (const Additions& additions :
       {Additions{.state = true}, Additions{.labels = true, .objects = true}}) {
    MakeOptions options = demonstration_options(additions);
    options.num_envs = 2;
    options.threads = 1;
    const auto batch = make("RememberColor3-VLA-v0", options);
    batch->reset();
    DemonstrationRecorder recorder(additions);
    recorder.start(*batch, 1);
    std::vector<float> rows;
    std::vector<float> actions(14);
    while ((batch->outputs().terminated[1] | batch->outputs().truncated[1]) == 0) {
      append(rows, row_of(batch->outputs().observation, *batch, 1));
      ScriptedPolicy(*batch, Policy::kOracle).act(actions);
      recorder.before_step(*batch, 1, std::span(actions).subspan(7));
      batch->step(actions);
      recorder.after_step(*batch, 1);
    }
    const Demonstration demonstration = recorder.finish();
    REQUIRE(demonstration.success);
    const TemporaryFolder folder;
    write_file(folder.path() / "a.npz", demonstration.file);
    const NpzFile file(folder.path() / "a.npz");
    const std::int64_t shape[] = {demonstration.length, batch->state_dim()};
    const std::vector<std::byte> found =
        file.read(additions.state ? "state" : "objects", NpyType::kFloat32, shape);
    CHECK(std::ranges::equal(found, bytes_of(rows)));
  }
  CHECK_THROWS_WITH(demonstration_options({.state = true, .objects = true}),
                    "state and objects given; one of them allowed");
}

TEST_CASE("Demonstrations: depth and segmentation as the cameras give them", "[demonstrations]") {
  for (const Additions& additions :
       {Additions{.depth = true}, Additions{.segmentation = true},
        Additions{.labels = true, .depth = true, .segmentation = true}}) {
    MakeOptions options = demonstration_options(additions);
    options.num_envs = 2;
    options.threads = 1;
    const auto batch = make("RememberColor3-VLA-v0", options);
    batch->reset();
    DemonstrationRecorder recorder(additions);
    recorder.start(*batch, 1);
    std::vector<std::int16_t> depth;
    std::vector<std::int16_t> segmentation;
    const auto keep = [&](std::vector<std::int16_t>& to, std::span<const std::int16_t> values) {
      to.insert(to.end(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                values.end());
    };
    std::vector<float> actions(14);
    while ((batch->outputs().terminated[1] | batch->outputs().truncated[1]) == 0) {
      keep(depth, batch->images().depth);
      keep(segmentation, batch->images().segmentation);
      ScriptedPolicy(*batch, Policy::kOracle).act(actions);
      recorder.before_step(*batch, 1, std::span(actions).subspan(7));
      batch->step(actions);
      recorder.after_step(*batch, 1);
    }
    const Demonstration demonstration = recorder.finish();
    REQUIRE(demonstration.success);
    const TemporaryFolder folder;
    write_file(folder.path() / "a.npz", demonstration.file);
    const NpzFile file(folder.path() / "a.npz");
    const std::int64_t shape[] = {demonstration.length, 128, 128, 2};
    const auto same = [&](const char* name, bool there, const std::vector<std::int16_t>& values) {
      if (!there) {
        CHECK_THROWS(file.shape(name, NpyType::kUint16));
        return;
      }
      const auto stored = file.read(name, NpyType::kUint16, shape);
      REQUIRE(stored.size() == 2 * values.size());
      CHECK(std::memcmp(stored.data(), values.data(), stored.size()) == 0);
      CHECK(*std::max_element(values.begin(), values.end()) > 3);
      CHECK(*std::min_element(values.begin(), values.end()) >= 0);
    };
    same("depth", additions.depth, depth);
    same("segmentation", additions.segmentation, segmentation);
    const std::string bytes(reinterpret_cast<const char*>(demonstration.file.data()),
                            demonstration.file.size());
    CHECK((bytes.find("segmentation_names.npy") != std::string::npos) == additions.segmentation);
  }
}

}  // namespace engram::test
