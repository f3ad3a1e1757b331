// `engram collect`: its files, and that nothing shows how they were made.
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <map>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "tests/apps/command.h"
#include "tests/apps/killed_run.h"
#include "tests/build_paths.h"
#include "tests/sanitizers.h"

namespace engram::test {
namespace {

namespace fs = std::filesystem;

// Content of every data file below a folder, by its path.
std::map<std::string, std::string> files_in(const fs::path& out) {
  const fs::path root = out / "data_npz";
  std::map<std::string, std::string> files;
  if (!fs::exists(root)) return files;
  for (const auto& item : fs::recursive_directory_iterator(root)) {
    // Those that an interrupted run has left for its continuation.
    const bool waiting = item.path().parent_path().filename() == "waiting" ||
                         item.path().filename() == "episodes.journal";
    if (item.is_regular_file() && !waiting) {
      files[fs::relative(item.path(), root).string()] = read_file(item.path());
    }
  }
  return files;
}

std::string collection(const std::string& options, const fs::path& out) {
  return "collect " + options + " --out " + out.string();
}

}  // namespace

TEST_CASE("collect: files and document", "[apps]") {
  const TemporaryFolder folder;
  const ParsedJson document =
      engram_command(collection("RememberColor3-VLA-v0 BlinkCountButtonPressEasy-VLA-v0 "
                                "--episodes 3 --json",
                                folder.path()))
          .json();
  CHECK(keys_of(document) ==
        std::vector<std::string>{"out", "format", "episodes", "steps", "tasks"});
  CHECK(document["format"] == "npz");
  CHECK(document["episodes"] == 6);
  REQUIRE(document["tasks"].size() == 2);
  std::int64_t steps = 0;
  for (const ParsedJson& task : document["tasks"]) {
    const auto id = task["env_id"].get<std::string>();
    const fs::path path = folder.path() / "data_npz" / id;
    CHECK(task["out"] == path.string());
    const ParsedJson metadata = ParsedJson::parse(read_file(path / "metadata.json"));
    CHECK(keys_of(metadata) == std::vector<std::string>{"env_id", "num_episodes", "episode_lengths",
                                                        "success_once", "reward_sums",
                                                        "episode_seeds", "batched_source_dir",
                                                        "unbatched_dir", "engram", "checksum"});
    CHECK(metadata["env_id"] == id);
    CHECK(metadata["num_episodes"] == 3);
    CHECK(metadata["success_once"] == std::vector<bool>(3, true));
    for (const ParsedJson& length : metadata["episode_lengths"])
      steps += length.get<std::int64_t>();
    for (int i = 0; i < 3; ++i) {
      CHECK(read_file(path / ("train_data_" + std::to_string(i) + ".npz")).starts_with("PK"));
    }
  }
  CHECK(document["steps"] == steps);
  CHECK(files_in(folder.path()).size() == 8);
  const std::string report = read_file(folder.path() / "collect_report.html");
  CHECK_THAT(report, Catch::StartsWith("<!DOCTYPE html>") &&
                         Catch::Contains("BlinkCountButtonPressEasy-VLA-v0") &&
                         Catch::Contains("data:image/png;base64,"));
  // Nothing is left to do, so nothing changes.
  const auto before = files_in(folder.path());
  CHECK(engram_command(collection("RememberColor3-VLA-v0 --episodes 3", folder.path())).code == 0);
  CHECK(files_in(folder.path()) == before);
}

TEST_CASE("collect: bytes do not depend on threads, batches or interruptions", "[apps]") {
  const std::string ids = "ShellGameTouch-VLA-v0 BlinkCountButtonPressEasy-VLA-v0 ";
  const TemporaryFolder reference;
  REQUIRE(engram_command(collection(ids + "--episodes 4 --threads 1", reference.path())).code == 0);
  const auto expected = files_in(reference.path());
  REQUIRE(expected.size() == 10);
  for (const char* how : {"--threads 2 --num-envs 1", "--threads 3 --num-envs 4"}) {
    const TemporaryFolder folder;
    REQUIRE(engram_command(collection(ids + "--episodes 4 " + how, folder.path())).code == 0);
    CHECK(files_in(folder.path()) == expected);
  }
  const TemporaryFolder grown;
  for (const char* episodes : {"--episodes 1", "--episodes 3", "--episodes 4"}) {
    REQUIRE(engram_command(collection(ids + episodes, grown.path())).code == 0);
  }
  CHECK(files_in(grown.path()) == expected);
}

TEST_CASE("collect: labels, whatever the threads, and none without being asked for",
          "[apps][labels]") {
  const std::string ids = "RememberColor3-VLA-v0 BlinkCountButtonPressEasy-VLA-v0 --episodes 3 ";
  const TemporaryFolder labelled;
  REQUIRE(engram_command(collection(ids + "--labels --threads 1", labelled.path())).code == 0);
  const TemporaryFolder again;
  REQUIRE(
      engram_command(collection(ids + "--labels --threads 3 --num-envs 2", again.path())).code ==
      0);
  CHECK(files_in(again.path()) == files_in(labelled.path()));
  const fs::path metadata = fs::path("data_npz") / "RememberColor3-VLA-v0" / "metadata.json";
  const ParsedJson origin = ParsedJson::parse(read_file(labelled.path() / metadata))["engram"];
  CHECK(origin["labels"]["open"] == std::vector<std::string>{"paraphrases"});
  const CommandResult other = engram_command(collection(ids, labelled.path()));
  CHECK(other.code != 0);
  CHECK_THAT(other.err, Catch::Contains("was collected with labels, without labels given"));
  const TemporaryFolder plain;
  REQUIRE(engram_command(collection(ids, plain.path())).code == 0);
  CHECK_FALSE(ParsedJson::parse(read_file(plain.path() / metadata))["engram"].contains("labels"));
}

TEST_CASE("collect: failures are kept on request", "[apps]") {
  const TemporaryFolder folder;
  const std::string words = "RememberColor9-VLA-v0 --control-mode pd_joint_delta_pos --episodes ";
  REQUIRE(engram_command(collection(words + "4 --keep-failures", folder.path())).code == 0);
  // A repeated command continues.
  REQUIRE(engram_command(collection(words + "8 --keep-failures", folder.path())).code == 0);
  const fs::path path = folder.path() / "data_npz" / "RememberColor9-VLA-v0";
  const ParsedJson metadata = ParsedJson::parse(read_file(path / "metadata.json"));
  CHECK(metadata["engram"]["keep_failures"] == true);
  CHECK(metadata["episode_seeds"] == ParsedJson({0, 1, 2, 3, 4, 5, 6, 7}));
  int successes = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    const bool success = metadata["success_once"][i];
    if (success) ++successes;
    if (!success) CHECK(metadata["episode_lengths"][i] == 25);
  }
  CHECK(successes > 0);
  CHECK(successes < 8);
  CHECK(engram_command(collection(words + "8", folder.path())).code == 2);
}

void check_collection_after_kills(int most) {
  const std::string ids = "RememberColor3-VLA-v0 BlinkCountButtonPressEasy-VLA-v0 ";
  const TemporaryFolder reference;
  const auto start = std::chrono::steady_clock::now();
  REQUIRE(engram_command(collection(ids + "--episodes 10", reference.path())).code == 0);
  const std::chrono::duration<double> whole = std::chrono::steady_clock::now() - start;
  const auto expected = files_in(reference.path());
  REQUIRE(expected.size() == 22);

  std::mt19937 random(1);
  std::uniform_int_distribution<std::size_t> more(0, 2);
  std::uniform_real_distribution<double> share(0, 0.1);
  const TemporaryFolder folder;
  int kills = 0;
  int rounds_with_files = 0;
  while (kills < most) {
    if (files_in(folder.path()).size() == expected.size())
      fs::remove_all(folder.path() / "data_npz");
    const std::string out = folder.path().string();
    const pid_t child = ::fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      const int null = ::open("/dev/null", O_RDWR);
      ::dup2(null, 1);
      ::dup2(null, 2);
      ::execl(test::kCommand, "engram", "collect", "RememberColor3-VLA-v0",
              "BlinkCountButtonPressEasy-VLA-v0", "--episodes", "10", "--out", out.c_str(),
              nullptr);
      ::_exit(127);
    }
    // On a busy machine, too, episodes are written between some of the kills.
    const std::size_t enough = files_below(folder.path(), ".npz") + more(random);
    while (files_below(folder.path(), ".npz") < enough && !has_ended(child)) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    std::this_thread::sleep_for(whole * share(random));
    ::kill(child, SIGKILL);
    int status = 0;
    REQUIRE(::waitpid(child, &status, 0) == child);
    if (WIFSIGNALED(status)) ++kills;
    // Existing files are complete and unchanged; only the metadata may be younger.
    int episodes = 0;
    for (const auto& [name, bytes] : files_in(folder.path())) {
      if (!name.ends_with(".npz")) continue;
      ++episodes;
      REQUIRE(expected.count(name) == 1);
      REQUIRE(bytes == expected.at(name));
    }
    if (episodes > 0) ++rounds_with_files;
  }
  CHECK(rounds_with_files > 3);
  REQUIRE(engram_command(collection(ids + "--episodes 10", folder.path())).code == 0);
  CHECK(files_in(folder.path()) == expected);
  CHECK(files_below(folder.path(), ".journal") == 0);
  CHECK(files_below(folder.path(), ".npz") == 20);
}

TEST_CASE("collect: continues after a kill at any moment", "[apps]") {
  check_collection_after_kills(5);
}

TEST_CASE("collect: continues after many kills", "[apps][long]") {
  check_collection_after_kills(25);
}

TEST_CASE("collect: a full disk ends the run, and what was complete stays", "[apps]") {
  const TemporaryFolder folder;
  const std::string options = "TraceShapeEasy-VLA-v0 --episodes 2";
  REQUIRE(engram_command(collection("TraceShapeEasy-VLA-v0 --episodes 1", folder.path())).code ==
          0);
  const auto before = files_in(folder.path());
  // No file may exceed that number of blocks of 1 KiB: enough for the metadata, not for an episode.
  const std::string line = std::string("trap '' XFSZ; ulimit -f 40; ") + test::kNoTemporaryFolder +
                           "'" + test::kCommand + "' " + collection(options, folder.path()) +
                           " >/dev/null 2>'" + (folder.path() / "err").string() + "'";
  const int status = std::system(("bash -c \"" + line + "\"").c_str());
  CHECK(WEXITSTATUS(status) == 1);
  CHECK_THAT(
      read_file(folder.path() / "err"),
      Catch::Contains("train_data_1.npz' cannot be written") && Catch::Contains("too large"));
  CHECK(files_in(folder.path()) == before);
}

TEST_CASE("collect: impossible requests are refused", "[apps]") {
  const TemporaryFolder folder;
  const std::string out = " --out " + folder.path().string();
  require_refusal("collect NoSuchTask-VLA-v0" + out, 2, "NoSuchTask-VLA-v0");
  require_refusal("collect RememberColor3-VLA-v0 --episodes 0" + out, 2, "--episodes");
  require_refusal("collect RememberColor3-VLA-v0 --seed 9223372036854775807" + out, 2,
                  "seeds up to");
  std::ofstream(folder.path() / "file") << "in the way";
  require_refusal("collect RememberColor3-VLA-v0" + out + "/file", 1, "file/data_npz");
}

TEST_CASE("collect: an interruption says that the same command goes on", "[apps]") {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "out").string();
  const std::string line = collection("RememberColor3-VLA-v0 --episodes 100000", out);
  const std::string signal =
      "& p=$!; while [ ! -e " + out +
      "/data_npz/RememberColor3-VLA-v0/train_data_0.npz ]; do sleep 0.02; done; kill -INT $p; "
      "wait $p";
  const CommandResult result = engram_command(line, signal);
  CHECK(result.code == 1);
  CHECK(result.out.empty());
  CHECK_THAT(result.err, Catch::StartsWith("engram: interrupted; ") &&
                             Catch::Contains("of 100000 episodes are in '" + out +
                                             "'; the same command goes on with the others\n"));
}

}  // namespace engram::test
