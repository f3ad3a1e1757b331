// What is recorded of an episode, and which episodes become files.
#include "protocol/demonstrations/recorder.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/env/scripted_policy.h"
#include "protocol/demonstrations/folder.h"
#include "protocol/demonstrations/npz.h"
#include "protocol/formats/files.h"
#include "tests/failing_allocations.h"
#include "tests/tasks/benchmark_table.h"
#include "tests/temporary_folder.h"

namespace engram::tests {
namespace {

namespace fs = std::filesystem;

const RegistryEntry& batched_task = require_entry("RememberColor3-VLA-v0");
const RegistryEntry& planned_task = require_entry("TraceShapeEasy-VLA-v0");

// As if played: `length` steps with reward 1/4 each.
Demonstration made_up(std::uint64_t seed, int length = 12, bool success = true) {
  const auto steps = static_cast<std::int64_t>(length);
  const std::int32_t count = length;
  const auto number = static_cast<std::int64_t>(seed);
  const std::vector<std::uint8_t> rgb(static_cast<std::size_t>(length) * 6);
  const std::vector<float> rewards(static_cast<std::size_t>(length), 0.25F);
  const NpyArray arrays[] = {{"rgb", NpyType::kUint8, {steps, 1, 1, 6}, bytes_of(rgb)},
                             {"reward", NpyType::kFloat32, {steps}, bytes_of(rewards)},
                             {"episode_length", NpyType::kInt32, {}, bytes_of(count)},
                             {"episode_seed", NpyType::kInt64, {}, bytes_of(number)}};
  if (!success) return {};
  return {true, count, 0.25 * length, npz_bytes(arrays)};
}

std::vector<std::int64_t> seeds_in(const DemonstrationFolder& folder) {
  const Document metadata = folder.metadata();
  std::vector<std::int64_t> seeds;
  for (const Document& seed : list(part(metadata, "episode_seeds"))) {
    seeds.push_back(static_cast<std::int64_t>(whole_number(seed)));
  }
  return seeds;
}

// Name and content of everything in a folder.
std::set<std::pair<std::string, std::string>> content(const fs::path& folder) {
  std::set<std::pair<std::string, std::string>> all;
  for (const auto& item : fs::directory_iterator(folder)) {
    all.emplace(item.path().filename().string(), read_file(item.path()));
  }
  return all;
}

}  // namespace

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
}

TEST_CASE("Demonstrations: a recorded episode can be played again", "[demonstrations]") {
  for (const char* id :
       {"RememberColor3-VLA-v0", "ShellGamePush-VLA-v0", "RotateStrictPos-VLA-v0"}) {
    INFO(id);
    constexpr std::uint64_t kSeed = 4'242'424'242'424;
    BatchOptions options = demonstration_options();
    options.num_envs = 2;
    options.threads = 1;
    const auto env = make(id, options);
    const std::vector<std::uint64_t> seeds = {kSeed - 1, kSeed};
    env->reset({.mask = {}, .seeds = seeds, .pins = nullptr});
    DemonstrationRecorder recorder;
    recorder.start(*env, 1);
    std::vector<float> actions(14);
    while ((env->terminated()[1] | env->truncated()[1]) == 0) {
      ScriptedPolicy(*env, Policy::kOracle).act(actions);
      recorder.before_step(*env, 1, std::span(actions).subspan(7));
      env->step(actions);
      recorder.after_step(*env, 1);
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
    const std::int64_t sevens[] = {steps, 7};
    const std::int64_t singles[] = {steps};
    const auto rgb = file.read("rgb", NpyType::kUint8, frames);
    const auto proprio = file.read("proprio", NpyType::kFloat32, sevens);
    const auto stored = file.read("action", NpyType::kFloat32, sevens);
    const auto reward = file.read("reward", NpyType::kFloat32, singles);
    const auto success = file.read("success", NpyType::kInt32, singles);
    CHECK(success == file.read("done", NpyType::kInt32, singles));

    // A fresh environment of the library's defaults shows the same.
    const auto again =
        make(id, {.num_envs = 1, .seed = kSeed, .threads = 1, .obs_mode = ObsMode::kRgb});
    again->reset();
    bool equal = true;
    double sum = 0;
    std::vector<float> action(7);
    for (std::size_t t = 0; t < static_cast<std::size_t>(steps); ++t) {
      const auto same = [t](const auto& shown, const std::vector<std::byte>& all) {
        const auto bytes = std::as_bytes(shown);
        return std::memcmp(bytes.data(), all.data() + t * bytes.size(), bytes.size()) == 0;
      };
      equal = equal && same(again->images().rgb, rgb) && same(again->proprio(), proprio);
      std::memcpy(action.data(), stored.data() + t * 28, 28);
      CHECK(std::all_of(action.begin(), action.end(), [](float a) { return a >= -1 && a <= 1; }));
      again->step(action);
      equal = equal && same(again->reward(), reward);
      CHECK((again->success()[0] != 0) == (t + 1 == static_cast<std::size_t>(steps)));
      std::int32_t told = 0;
      std::memcpy(&told, success.data() + t * 4, 4);
      CHECK(told == again->success()[0]);
      sum += static_cast<double>(again->reward()[0]);
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

TEST_CASE("Demonstrations: a batch is kept whole or not at all", "[demonstrations]") {
  const TemporaryFolder root;
  DemonstrationFolder folder(root.path(), batched_task, {.episodes = 15, .start_seed = 100});
  CHECK(folder.next_seed() == 100);
  CHECK(folder.attempt_end(104) == 110);
  // The second batch is known before the first; one of its episodes failed.
  for (std::uint64_t seed = 110; seed < 120; ++seed)
    folder.accept(seed, made_up(seed, 12, seed != 113));
  CHECK(folder.episodes() == 0);
  for (std::uint64_t seed = 100; seed < 109; ++seed)
    folder.accept(seed, made_up(seed, seed == 105 ? 9 : 12));
  CHECK(folder.episodes() == 0);
  CHECK(!fs::exists(folder.path() / "train_data_0.npz"));
  folder.accept(109, made_up(109));
  // One was too short.
  CHECK(seeds_in(folder) == std::vector<std::int64_t>{100, 101, 102, 103, 104, 106, 107, 108, 109});
  CHECK(folder.next_seed() == 120);
  CHECK(!folder.finished());
  for (std::uint64_t seed = 129; seed >= 120; --seed) folder.accept(seed, made_up(seed));
  CHECK(folder.complete());
  CHECK(folder.episodes() == 15);
  CHECK(seeds_in(folder).back() == 125);
  CHECK(folder.attempts() == 3);
  CHECK(folder.steps() == 15 * 12);
}

TEST_CASE("Demonstrations: planned families take every success", "[demonstrations]") {
  const TemporaryFolder root;
  DemonstrationFolder folder(root.path(), planned_task, {.episodes = 3, .max_attempts = 4});
  folder.accept(1, made_up(1, 1));
  folder.accept(0, made_up(0, 5, false));
  CHECK(seeds_in(folder) == std::vector<std::int64_t>{1});
  folder.accept(2, made_up(2, 5, false));
  folder.accept(3, made_up(3));
  CHECK(folder.finished());  // out of attempts
  CHECK(!folder.complete());
  CHECK(folder.episodes() == 2);
}

TEST_CASE("Demonstrations: an interrupted folder is taken up again", "[demonstrations]") {
  const CollectionPlan plan{.episodes = 17, .start_seed = 7};
  const TemporaryFolder whole;
  {
    DemonstrationFolder folder(whole.path(), batched_task, plan);
    for (std::uint64_t seed = 7; !folder.finished(); ++seed) folder.accept(seed, made_up(seed));
  }
  const fs::path expected = whole.path() / "data_npz" / batched_task.id;
  REQUIRE(content(expected).size() == 18);
  // Interrupted after any number of files, the metadata one behind, with a half-written file.
  for (int files = 0; files <= 17; ++files) {
    const TemporaryFolder root;
    const fs::path path = root.path() / "data_npz" / batched_task.id;
    fs::create_directories(path);
    for (int i = 0; i < files; ++i) {
      const std::string name = "train_data_" + std::to_string(i) + ".npz";
      fs::copy_file(expected / name, path / name);
    }
    write_file(path / ("train_data_" + std::to_string(files) + ".npz.77.engram-tmp"), "half");
    {
      DemonstrationFolder folder(root.path(), batched_task, plan);
      CHECK(folder.episodes() == files);
      CHECK(folder.next_seed() == 7U + static_cast<unsigned>(files));
      const std::uint64_t first = folder.next_seed();
      for (std::uint64_t seed = first; !folder.finished(); ++seed) {
        folder.accept(seed, made_up(seed));
      }
    }
    CHECK(content(path) == content(expected));
  }
}

TEST_CASE("Demonstrations: what does not fit is refused and stays as it is", "[demonstrations]") {
  const TemporaryFolder root;
  const CollectionPlan plan{.episodes = 3};
  fs::path path;
  {
    DemonstrationFolder folder(root.path(), planned_task, plan);
    path = folder.path();
    for (std::uint64_t seed = 0; seed < 3; ++seed) folder.accept(seed, made_up(seed));
    CHECK_THROWS_WITH(DemonstrationFolder(root.path(), planned_task, plan),
                      Catch::Contains("in use"));
  }
  const auto before = content(path);
  const auto refuses = [&](const CollectionPlan& other, const std::string& words) {
    CHECK_THROWS_WITH(DemonstrationFolder(root.path(), planned_task, other),
                      Catch::Contains(words));
  };
  refuses({.episodes = 3, .start_seed = 1}, "start_seed 0, 1 given");
  refuses({.episodes = 3, .renderer = "egl"}, "renderer \"cpu\", \"egl\" given");
  refuses({.episodes = 3, .start_seed = kMaxDemonstrationSeed}, "seeds up to");
  CHECK(content(path) == before);

  const auto damages = [&](const std::string& name, std::string_view text,
                           const std::string& words) {
    write_file(path / name, text);
    refuses(plan, words);
    CHECK(read_file(path / name) == text);
    for (const auto& [file, bytes] : before) write_file(path / file, bytes);
  };
  const std::string good = read_file(path / "train_data_1.npz");
  damages("train_data_1.npz", "", "train_data_1.npz' is not a data file of engram, or damaged");
  damages("train_data_1.npz", good.substr(0, good.size() / 2), "damaged");
  damages("train_data_1.npz", read_file(path / "train_data_0.npz"), "has seed 0, 1 to ");
  damages("metadata.json", "{\"env_id\": ", "metadata.json' is damaged");
  write_file(path / "train_data_4.npz", good);
  refuses(plan, "train_data_3.npz' is missing");
  fs::remove(path / "train_data_4.npz");
  write_file(path / "train_data_0003.npz", good);
  refuses(plan, "without leading zeros");
  fs::remove(path / "train_data_0003.npz");
  CHECK(content(path) == before);
  // Without metadata the files themselves tell.
  fs::remove(path / "metadata.json");
  CHECK(DemonstrationFolder(root.path(), planned_task, plan).complete());
  CHECK(content(path) == before);
}

TEST_CASE("Demonstrations: a folder that there is no memory for stays as it is",
          "[demonstrations][allocation]") {
  const TemporaryFolder root;
  const CollectionPlan plan{.episodes = 2};
  fs::path path;
  {
    DemonstrationFolder folder(root.path(), planned_task, plan);
    path = folder.path();
    for (std::uint64_t seed = 0; seed < 2; ++seed) folder.accept(seed, made_up(seed));
  }
  const auto before = content(path);
  const auto open = [&] {
    const DemonstrationFolder folder(root.path(), planned_task, plan);
    if (!folder.complete()) throw Error(Error::kInternal, "episodes are lost");
  };
  CHECK(test::fails_well_everywhere(open, [&] { CHECK((content(path) == before)); }) > 50);
}

}  // namespace engram::tests
