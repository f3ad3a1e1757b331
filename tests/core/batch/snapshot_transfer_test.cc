// Snapshots go on bit for bit wherever they are restored: in another slot, in another batch and in
// another process, which is this program once more.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "core/base/checksum.h"
#include "core/batch/snapshot.h"
#include "core/math/random.h"
#include "protocol/make/make.h"
#include "tasks/family_samples.h"
#include "tests/env_helpers.h"
#include "tests/temporary_folder.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

constexpr int kFuture = 10;  // steps that are compared

// A task and how it is observed.
struct Subject {
  std::string id;
  ObsMode obs_mode = ObsMode::kState;

  std::unique_ptr<Batch> batch(int num_envs, int threads, std::uint64_t seed) const {
    const BatchOptions options{
        .num_envs = num_envs, .seed = seed, .threads = threads, .obs_mode = obs_mode};
    return make(id, options);
  }
};

// The oracle's actions for even seeds, random ones for odd seeds.
void step(Batch& batch) {
  std::vector<float> actions = test::act(batch, Policy::kOracle);
  const std::vector<float> random = test::act(batch, Policy::kRandom);
  const auto dim = static_cast<std::size_t>(batch.action_dim());
  for (std::size_t i = 0; i < actions.size(); ++i) {
    if (batch.state().seed[static_cast<int>(i / dim)] % 2 == 1) actions[i] = random[i];
  }
  batch.step(actions);
}

// What one environment remembers and shows.
std::uint64_t digest(const Batch& batch, int index, std::uint64_t before) {
  const std::uint64_t hash = checksum(test::env_bytes(batch, index), before);
  const std::size_t image = batch.images().rgb.size() / static_cast<std::size_t>(batch.num_envs());
  return checksum(
      std::as_bytes(batch.images().rgb.subspan(static_cast<std::size_t>(index) * image, image)),
      hash);
}

// The futures of snapshots that are restored into neighbouring slots, from `slot` on.
std::vector<std::uint64_t> futures(Batch& batch, std::span<const test::Bytes> saved, int slot) {
  std::vector<std::uint64_t> hashes(saved.size(), kChecksumSeed);
  const auto note = [&] {
    for (std::size_t i = 0; i < saved.size(); ++i) {
      hashes[i] = digest(batch, (slot + static_cast<int>(i)) % batch.num_envs(), hashes[i]);
    }
  };
  for (std::size_t i = 0; i < saved.size(); ++i) {
    Snapshotter(batch).restore((slot + static_cast<int>(i)) % batch.num_envs(), saved[i]);
  }
  note();
  for (int i = 0; i < kFuture; ++i) {
    step(batch);
    note();
  }
  return hashes;
}

// Futures of more snapshots than there are environments.
std::vector<std::uint64_t> all_futures(Batch& batch, std::span<const test::Bytes> saved) {
  std::vector<std::uint64_t> hashes;
  while (!saved.empty()) {
    const auto some =
        saved.first(std::min(saved.size(), static_cast<std::size_t>(batch.num_envs())));
    for (const std::uint64_t hash : futures(batch, some, 2)) hashes.push_back(hash);
    saved = saved.subspan(some.size());
  }
  return hashes;
}

// An episode under way, with snapshots at random steps and what came after them.
struct Journey {
  std::vector<test::Bytes> saved;
  std::vector<int> slots;  // where they were taken
  std::vector<std::uint64_t> futures;
};

// Takes snapshots at `count` random steps before `end`, each of a random environment.
Journey travel(Batch& batch, int count, int end, std::uint64_t seed) {
  RandomStream random(seed, 0, 0);
  std::vector<int> steps;
  steps.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) steps.push_back(random.integer(0, end - 1));
  std::sort(steps.begin(), steps.end());
  Journey journey;
  journey.futures.assign(steps.size(), kChecksumSeed);
  batch.reset();
  for (int now = 0; now <= steps.back() + kFuture; ++now) {
    if (now > 0) step(batch);
    for (std::size_t i = 0; i < steps.size(); ++i) {
      if (steps[i] == now) {
        journey.slots.push_back(random.integer(0, batch.num_envs() - 1));
        journey.saved.push_back(Snapshotter(batch).save(journey.slots.back()));
      }
      if (steps[i] <= now && now <= steps[i] + kFuture) {
        journey.futures[i] = digest(batch, journey.slots[i], journey.futures[i]);
      }
    }
  }
  return journey;
}

// --- another process ---

constexpr const char* kFolderVariable = "ENGRAM_TEST_SNAPSHOTS";

void write_journey(const fs::path& folder, const Subject& subject, const Journey& journey) {
  fs::create_directories(folder);
  std::ofstream(folder / "subject") << subject.id << '\n'
                                    << static_cast<int>(subject.obs_mode) << '\n'
                                    << journey.saved.size();
  for (std::size_t i = 0; i < journey.saved.size(); ++i) {
    std::ofstream(folder / std::to_string(i), std::ios::binary)
        .write(reinterpret_cast<const char*>(journey.saved[i].data()),
               static_cast<std::streamsize>(journey.saved[i].size()));
  }
}

// What the other process does; hidden, for it needs a folder of journeys.
TEST_CASE("Snapshots from a folder go on", "[.continue_snapshots]") {
  const char* root = std::getenv(kFolderVariable);
  REQUIRE(root != nullptr);
  for (const auto& entry : fs::directory_iterator(root)) {
    Subject subject;
    int obs_mode = 0;
    std::size_t count = 0;
    std::ifstream(entry.path() / "subject") >> subject.id >> obs_mode >> count;
    subject.obs_mode = static_cast<ObsMode>(obs_mode);
    std::vector<test::Bytes> saved;
    for (std::size_t i = 0; i < count; ++i) {
      const std::string bytes = test::read_file(entry.path() / std::to_string(i));
      const auto all = std::as_bytes(std::span(bytes));
      saved.emplace_back(all.begin(), all.end());
    }
    const auto batch = subject.batch(4, 2, 700);
    batch->reset();
    std::ofstream out(entry.path() / "futures");
    for (const std::uint64_t hash : all_futures(*batch, saved)) out << hash << '\n';
  }
}

std::vector<std::uint64_t> read_futures(const fs::path& folder) {
  std::ifstream file(folder / "futures");
  std::vector<std::uint64_t> hashes;
  for (std::uint64_t hash = 0; file >> hash;) hashes.push_back(hash);
  return hashes;
}

void continue_elsewhere(const fs::path& root) {
  const std::string program = fs::read_symlink("/proc/self/exe").string();
  const std::string line = std::string(kFolderVariable) + "='" + root.string() + "' '" + program +
                           "' '[.continue_snapshots]' >'" + (root.string() + ".log") + "' 2>&1";
  const int status = std::system(line.c_str());
  INFO(test::read_file(root.string() + ".log"));
  REQUIRE(status == 0);
}

// --- the checks ---

// Snapshots at `count` random steps of each subject's first `limit` steps.
void check_travel(const std::vector<Subject>& subjects, int count, int limit) {
  const test::TemporaryFolder temporary;
  const fs::path root = temporary.path() / "journeys";
  std::vector<Journey> journeys;
  for (const Subject& subject : subjects) {
    INFO(subject.id);
    const auto seed = static_cast<std::uint64_t>(100 * journeys.size());
    const auto batch = subject.batch(3, 2, seed);
    const int end = std::min(limit, batch->info().horizon);
    const Journey& journey = journeys.emplace_back(travel(*batch, count, end, seed));
    for (std::size_t i = 0; i < journey.saved.size(); ++i) {  // into another slot
      const auto again = futures(*batch, {&journey.saved[i], 1}, (journey.slots[i] + 1) % 3);
      CHECK(again.front() == journey.futures[i]);
    }
    const auto other = subject.batch(5, 3, 900);
    other->reset();
    CHECK((all_futures(*other, journey.saved) == journey.futures));
    write_journey(root / std::to_string(journeys.size() - 1), subject, journey);
  }
  continue_elsewhere(root);
  for (std::size_t i = 0; i < subjects.size(); ++i) {
    INFO(subjects[i].id);
    CHECK((read_futures(root / std::to_string(i)) == journeys[i].futures));
  }
}

// One task of each family.
std::vector<Subject> families(ObsMode obs_mode) {
  std::vector<Subject> subjects;
  for (const std::string& id : one_of_each_family()) subjects.push_back({id, obs_mode});
  return subjects;
}

TEST_CASE("Snapshots of every family go on in another process", "[snapshot]") {
  check_travel(families(ObsMode::kState), 4, 40);
}

TEST_CASE("Snapshots go on with the same images in another process", "[snapshot]") {
  check_travel({{"ShellGamePick-VLA-v0", ObsMode::kRgb}}, 3, 30);
}

TEST_CASE("Snapshots of every task go on anywhere from any step", "[snapshot][long]") {
  std::vector<Subject> subjects;
  for (const std::string& id : test::implemented_ids()) subjects.push_back({id});
  check_travel(subjects, 20, 1'000'000);
}

TEST_CASE("Snapshots of every family go on anywhere with the same images", "[snapshot][long]") {
  check_travel(families(ObsMode::kRgb), 20, 1'000'000);
}

}  // namespace
}  // namespace engram
