// Data in the layout of the benchmark's RL half: whole episodes, the same files for any threads.
#include "protocol/datasets/rl_collection.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/batch/scripted_policy.h"
#include "protocol/datasets/npz.h"
#include "tests/env_helpers.h"
#include "tests/temporary_folder.h"

namespace engram::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kId = "ShellGamePush-v0";
constexpr int kSteps = 90;

fs::path folder_of(const fs::path& root) { return root / "MIKASA-Robo" / "unbatched" / kId; }

std::map<std::string, std::string> files_in(const fs::path& root) {
  std::map<std::string, std::string> files;
  for (const auto& item : fs::directory_iterator(folder_of(root))) {
    files[item.path().filename().string()] = read_file(item.path());
  }
  return files;
}

CollectionOptions options_for(const fs::path& root, int episodes, int threads = 1) {
  CollectionOptions options;
  options.plan.episodes = episodes;
  options.plan.start_seed = 30;
  options.out = root;
  options.threads = threads;
  return options;
}

std::vector<std::unique_ptr<RlFolder>> collect_into(const CollectionOptions& options) {
  Ranks alone;
  const RegistryEntry* const tasks[] = {&require_entry(kId)};
  return collect_rl(alone, tasks, options, [](const CollectionProgress&) {});
}

template <class T>
std::vector<T> values(const NpzFile& file, const char* name, NpyType type,
                      const std::vector<std::int64_t>& shape) {
  CHECK(file.shape(name, type) == shape);
  const std::vector<std::byte> bytes = file.read(name, type, shape);
  std::vector<T> result(bytes.size() / sizeof(T));
  std::memcpy(result.data(), bytes.data(), bytes.size());
  return result;
}

TEST_CASE("RL data are whole episodes of the oracle, step for step", "[datasets][rl]") {
  const TemporaryFolder root;
  {
    const auto folders = collect_into(options_for(root.path(), 3));
    REQUIRE(folders.size() == 1);
    CHECK(folders[0]->episodes() == 3);
    CHECK(folders[0]->steps() == 3 * kSteps);
    CHECK(folders[0]->success_once() == 1);
  }
  // Nothing but the episodes.
  CHECK(files_in(root.path()).size() == 3);
  const auto batch = test::make_running(
      kId, {.seed = 31, .auto_reset = AutoReset::kOff, .terminate_on_success = false});
  const NpzFile file(folder_of(root.path()) / "train_data_1.npz");
  const auto rgb = values<std::uint8_t>(file, "rgb", NpyType::kUint8, {kSteps, 128, 128, 6});
  const auto joints = values<float>(file, "joints", NpyType::kFloat32, {kSteps, 25});
  const auto actions = values<float>(file, "action", NpyType::kFloat32, {kSteps, 8});
  const auto rewards = values<float>(file, "reward", NpyType::kFloat32, {kSteps});
  const auto successes = values<std::int64_t>(file, "success", NpyType::kInt64, {kSteps});
  const auto dones = values<std::int64_t>(file, "done", NpyType::kInt64, {kSteps});
  CHECK(std::ranges::count(rgb, 0) < static_cast<std::ptrdiff_t>(rgb.size() / 2));
  for (std::size_t t = 0; t < kSteps; ++t) {
    INFO("step " << t);
    const State& state = batch->state();
    for (std::size_t i = 0; i < 3; ++i) {
      CHECK(joints[25 * t + i] == static_cast<float>(state.tcp_pos.row(0)[i]));
    }
    CHECK(joints[25 * t + 3] == static_cast<float>(state.tcp_quat.row(0)[0]));
    for (std::size_t i = 0; i < 9; ++i) {
      CHECK(joints[25 * t + 7 + i] == static_cast<float>(state.qpos.row(0)[i]));
      CHECK(joints[25 * t + 16 + i] == static_cast<float>(state.qvel.row(0)[i]));
    }
    const std::vector<float> action = test::act(*batch, Policy::kOracle);
    CHECK(std::equal(action.begin(), action.end(), actions.begin() + 8 * static_cast<int>(t)));
    batch->step(action);
    CHECK(rewards[t] == batch->outputs().reward[0]);
    CHECK(successes[t] == batch->outputs().success[0]);
    CHECK(dones[t] == (t == kSteps - 1 ? 1 : 0));
  }
  CHECK(std::ranges::count(successes, 1) > 1);  // an episode goes on after its success
}

TEST_CASE("RL data do not depend on threads, and go on where they stopped", "[datasets][rl]") {
  const TemporaryFolder root;
  const TemporaryFolder other;
  collect_into(options_for(root.path(), 12));
  CollectionOptions options = options_for(other.path(), 12, 2);
  options.num_envs = 3;
  collect_into(options);
  const auto files = files_in(root.path());
  CHECK(files.size() == 12);
  CHECK((files_in(other.path()) == files));
  fs::remove(folder_of(other.path()) / "train_data_4.npz");
  fs::remove(folder_of(other.path()) / "train_data_11.npz");
  CHECK(collect_into(options)[0]->episodes() == 12);
  CHECK((files_in(other.path()) == files));
  // More of them.
  options.plan.episodes = 13;
  collect_into(options);
  CHECK(files_in(other.path()).size() == 13);
}

TEST_CASE("RL data of different plans are not mixed", "[datasets][rl]") {
  const TemporaryFolder root;
  collect_into(options_for(root.path(), 1));
  const auto before = files_in(root.path());
  CollectionOptions options = options_for(root.path(), 2);
  options.plan.start_seed = 0;
  CHECK_THROWS_WITH(collect_into(options), Catch::Contains("was collected with start_seed 30, 0"));
  options = options_for(root.path(), 2);
  options.plan.rules = Rules::kOriginal;
  CHECK_THROWS_WITH(collect_into(options), Catch::Contains("was collected with rules"));
  options = options_for(root.path(), 2);
  options.plan.additions.labels = true;
  CHECK_THROWS_WITH(collect_into(options), Catch::Contains("RL data have none"));
  options = options_for(root.path(), 2);
  options.plan.control_mode = ControlMode::kPdJointVel;
  CHECK_THROWS_AS(collect_into(options), Error);
  CHECK((files_in(root.path()) == before));
}

TEST_CASE("Files that engram did not collect are not taken for its own", "[datasets][rl]") {
  const TemporaryFolder root;
  collect_into(options_for(root.path(), 2));
  const fs::path note = root.path() / "MIKASA-Robo" / (std::string(kId) + ".json");
  fs::remove(note);  // as in downloaded data
  const auto before = files_in(root.path());
  CHECK_THROWS_WITH(collect_into(options_for(root.path(), 3)),
                    Catch::Contains("is missing; another folder needed"));
  CHECK_FALSE(fs::exists(note));
  CHECK((files_in(root.path()) == before));
}

TEST_CASE("A damaged file among RL data is named, and nothing is written", "[datasets][rl]") {
  const TemporaryFolder root;
  collect_into(options_for(root.path(), 2));
  const fs::path damaged = folder_of(root.path()) / "train_data_1.npz";
  fs::resize_file(damaged, 0);
  const auto before = files_in(root.path());
  CHECK_THROWS_WITH(collect_into(options_for(root.path(), 3)), Catch::Contains("train_data_1.npz"));
  CHECK((files_in(root.path()) == before));
}

TEST_CASE("RL data of several tasks are refused as a whole", "[datasets][rl]") {
  const TemporaryFolder root;
  collect_into(options_for(root.path(), 1));
  CollectionOptions options = options_for(root.path(), 1);
  options.plan.start_seed = 5;
  Ranks alone;
  const RegistryEntry* const tasks[] = {&require_entry("RememberColor3-v0"), &require_entry(kId)};
  CHECK_THROWS_WITH(collect_rl(alone, tasks, options, [](const CollectionProgress&) {}),
                    Catch::Contains("was collected with start_seed 30, 5"));
  CHECK_FALSE(fs::exists(root.path() / "MIKASA-Robo" / "RememberColor3-v0.json"));
  CHECK_FALSE(fs::exists(root.path() / "MIKASA-Robo" / "unbatched" / "RememberColor3-v0"));
}

TEST_CASE("Seeds of RL data do not wrap round", "[datasets][rl]") {
  const TemporaryFolder root;
  CollectionOptions options = options_for(root.path(), 2);
  options.plan.start_seed = UINT64_MAX;
  CHECK_THROWS_WITH(collect_into(options), Catch::Contains("allowed, and 2 are planned"));
}

}  // namespace
}  // namespace engram::test
