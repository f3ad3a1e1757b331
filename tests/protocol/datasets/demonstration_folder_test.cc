#include "protocol/datasets/demonstration_folder.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "protocol/datasets/npz.h"
#include "protocol/io/files.h"
#include "tests/failing_allocations.h"
#include "tests/temporary_folder.h"

namespace engram::test {
namespace {

namespace fs = std::filesystem;

const RegistryEntry& batched_task = require_entry("RememberColor3-VLA-v0");
const RegistryEntry& planned_task = require_entry("TraceShapeEasy-VLA-v0");

// A made-up demonstration of `length` steps with reward 1/4 each.
Demonstration made_up(std::uint64_t seed, int length = 12, bool success = true) {
  const auto steps = static_cast<std::int64_t>(length);
  const std::int32_t count = length;
  const auto number = static_cast<std::int64_t>(seed);
  const std::vector<std::uint8_t> rgb(static_cast<std::size_t>(length) * 6);
  const std::vector<float> rewards(static_cast<std::size_t>(length), 0.25F);
  const NpyArray arrays[] = {{"rgb", NpyType::kUint8, {steps, 1, 1, 6}, bytes_of(rgb)},
                             {"reward", NpyType::kFloat32, {steps}, bytes_of(rewards)},
                             {"success_once", NpyType::kBool, {}, bytes_of(success)},
                             {"episode_length", NpyType::kInt32, {}, bytes_of(count)},
                             {"episode_seed", NpyType::kInt64, {}, bytes_of(number)}};
  if (!success) return {};
  return {true, count, 0.25 * length, npz_bytes(arrays)};
}

std::vector<std::int64_t> seeds_in(const DemonstrationFolder& folder) {
  const Json metadata = folder.metadata();
  std::vector<std::int64_t> seeds;
  for (const Json& seed : list(part(metadata, "episode_seeds"))) {
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

TEST_CASE("Demonstrations: metadata are not written for each of many episodes",
          "[demonstrations]") {
  const TemporaryFolder root;
  constexpr int kEpisodes = 400;
  DemonstrationFolder folder(root.path(), planned_task, {.episodes = kEpisodes});
  const auto described = [&folder] {
    const std::string text = read_file(folder.path() / "metadata.json");
    return static_cast<int>(whole_number(part(parse_json(text).value(), "num_episodes")));
  };
  int writes = 0;
  int before = 0;
  for (int episode = 0; episode < kEpisodes; ++episode) {
    const auto seed = static_cast<std::uint64_t>(episode);
    folder.accept(seed, made_up(seed));
    const int now = described();
    CHECK(now >= (episode + 1) * 64 / 65 - 1);
    writes += now == before ? 0 : 1;
    before = now;
  }
  CHECK(described() == kEpisodes);
  CHECK(writes < 200);
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

TEST_CASE("Demonstrations: seeds that wait for others are known after an interruption",
          "[demonstrations]") {
  const TemporaryFolder root;
  const CollectionPlan plan{.episodes = 15, .start_seed = 100};
  const auto fails = [](std::uint64_t seed) { return seed == 113; };
  {
    DemonstrationFolder folder(root.path(), batched_task, plan);
    for (std::uint64_t seed = 120; seed < 125; ++seed) folder.accept(seed, made_up(seed));
    for (std::uint64_t seed = 110; seed < 120; ++seed) {
      folder.accept(seed, made_up(seed, 12, !fails(seed)));
    }
    for (std::uint64_t seed = 100; seed < 110; ++seed) {
      if (seed != 104) folder.accept(seed, made_up(seed));
    }
    CHECK(folder.episodes() == 0);
  }
  DemonstrationFolder folder(root.path(), batched_task, plan);
  for (std::uint64_t seed = 100; seed < 130; ++seed) {
    CHECK(folder.knows(seed) == (seed != 104 && seed < 125));
  }
  CHECK(folder.waiting() == 23);
  folder.accept(104, made_up(104));
  CHECK(folder.episodes() == 10);
  CHECK(folder.next_seed() == 120);
  for (std::uint64_t seed = 125; seed < 130; ++seed) folder.accept(seed, made_up(seed));
  CHECK(folder.complete());
  CHECK(seeds_in(folder).back() == 124);
  // Nothing is left beside the data.
  CHECK(content(folder.path()).size() == 16 + 1);  // metadata, and the note of the lock
}

TEST_CASE("Demonstrations: failures of one seed each are not played again", "[demonstrations]") {
  const TemporaryFolder root;
  const CollectionPlan plan{.episodes = 3, .max_attempts = 9};
  {
    DemonstrationFolder folder(root.path(), planned_task, plan);
    for (std::uint64_t seed = 0; seed < 4; ++seed) folder.accept(seed, made_up(seed, 5, seed == 0));
    folder.accept(5, made_up(5));
  }
  DemonstrationFolder folder(root.path(), planned_task, plan);
  CHECK(folder.episodes() == 1);
  CHECK(folder.next_seed() == 4);
  CHECK(folder.knows(5));
}

TEST_CASE("Demonstrations: a file that waited and is lost is played again", "[demonstrations]") {
  const TemporaryFolder root;
  const CollectionPlan plan{.episodes = 3};
  fs::path path;
  {
    DemonstrationFolder folder(root.path(), planned_task, plan);
    path = folder.path();
    folder.accept(1, made_up(1));
    folder.accept(2, made_up(2));
  }
  fs::remove(path / "waiting" / "1.npz");
  const DemonstrationFolder folder(root.path(), planned_task, plan);
  CHECK_FALSE(folder.knows(1));
  CHECK(folder.knows(2));
}

TEST_CASE("Demonstrations: an interrupted folder is continued", "[demonstrations]") {
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

TEST_CASE("Demonstrations: a folder that does not fit is refused and unchanged",
          "[demonstrations]") {
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
  // Without metadata the files themselves are read.
  fs::remove(path / "metadata.json");
  CHECK(DemonstrationFolder(root.path(), planned_task, plan).complete());
  CHECK(content(path) == before);
}

TEST_CASE("Demonstrations: out of memory leaves a folder unchanged",
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

TEST_CASE("Demonstrations: a folder has labels in all files or in none",
          "[labels][demonstrations]") {
  const auto open = [](const TemporaryFolder& root, const Additions& additions) {
    CollectionPlan plan{.episodes = 1};
    plan.additions = additions;
    return DemonstrationFolder(root.path(), planned_task, plan).metadata();
  };
  const Additions kinds[] = {{.labels = true}, {.depth = true}, {.segmentation = true}};
  const std::string names[] = {"labels", "depth", "segmentation"};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string& name = names[i];
    const TemporaryFolder plain;
    CHECK(find(part(open(plain, {}), "engram"), name) == nullptr);
    CHECK_THROWS_WITH(open(plain, kinds[i]), Catch::Contains("was collected without " + name +
                                                             ", with " + name + " given"));
    const TemporaryFolder with;
    const Json metadata = open(with, kinds[i]);
    CHECK_THROWS_WITH(open(with, {}), Catch::Contains("was collected with " + name + ", without " +
                                                      name + " given"));
    CHECK(open(with, kinds[i]) == metadata);
    CHECK(part(part(metadata, "engram"), name) != Json());
  }
  const TemporaryFolder labelled;
  const Json metadata = open(labelled, {.labels = true});
  const Json& labels = part(part(metadata, "engram"), "labels");
  CHECK(list(part(labels, "open")) == JsonList{"paraphrases"});
  CHECK(list(part(labels, "privileged")).size() == 15);
}

}  // namespace engram::test
