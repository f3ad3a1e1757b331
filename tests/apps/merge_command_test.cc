// `engram merge`, and the shards that it makes one result of.
#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "tests/apps/command.h"
#include "tests/apps/killed_run.h"
#include "tests/build_paths.h"

namespace engram::test {
namespace {

namespace fs = std::filesystem;

// A path without the folder of a date.
std::string inside_of_run(const std::string& path) {
  const std::size_t split = path.find("short/");
  return split == 0 ? path.substr(path.find('/', 6) + 1) : path;
}

// Files below a folder but those with times, and those of shards.
std::map<std::string, std::string> results_below(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    const std::string inside = fs::relative(entry.path(), folder).string();
    const bool timed = name == "timing.json" || name == "report.html" || name == "probe.html";
    if (!entry.is_regular_file() || timed || inside.find("shard-") != std::string::npos) continue;
    files[inside_of_run(inside)] = read_file(entry.path());
  }
  return files;
}

// Runs all shards in that order; some are killed at random and run again.
void run_shards(const std::string& command, int count, const fs::path& out, int kills,
                std::mt19937& random) {
  std::vector<int> order;
  for (int number = 1; number <= count; ++number) order.push_back(number);
  std::ranges::shuffle(order, random);
  for (const int number : order) {
    const std::string line = command + " --shard " + std::to_string(number) + "/" +
                             std::to_string(count) + " --out " + out.string();
    if (kills-- > 0) {
      const fs::path journal =
          out / ("shard-" + std::to_string(number) + "-of-" + std::to_string(count)) /
          "episodes.journal";
      KilledCommand child(line);
      // Until there is something in the journal.
      const auto has_records = [&journal] {
        std::error_code missing;
        const auto size = fs::file_size(journal, missing);
        return !missing && size > 6000;
      };
      while (!has_records() && !child.has_ended()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      child.kill(SIGKILL);
    }
    const CommandResult result = engram_command(line);
    INFO(result.err);
    REQUIRE(result.code == 0);
  }
}

const std::string kEval =
    "eval RememberColor3-VLA-v0 TakeItBack-VLA-v0 InterceptMedium-VLA-v0 --policy oracle "
    "--episodes 9 --repeat 2 --num-envs 4";

TEST_CASE("merge: shards in any order, some killed, give the bytes of one process",
          "[apps][shards]") {
  const TemporaryFolder one;
  const TemporaryFolder many;
  REQUIRE(engram_command(kEval + " --out " + one.path().string()).code == 0);
  std::mt19937 random(5);
  run_shards(kEval, 4, many.path(), 2, random);
  const CommandResult merged = engram_command("merge " + many.path().string());
  INFO(merged.err);
  REQUIRE(merged.code == 0);
  CHECK_THAT(merged.out, Catch::Contains("TakeItBack-VLA-v0"));
  const auto expected = results_below(one.path());
  CHECK(expected.size() == 10);  // of three tasks; summary, tables, settings and pictures
  CHECK(results_below(many.path()) == expected);
}

TEST_CASE("merge: shards of probes", "[apps][shards]") {
  const std::string probe =
      "probe RememberColor3-VLA-v0 --policy blind --probes twins,capacity --episodes 5";
  const TemporaryFolder one;
  const TemporaryFolder many;
  REQUIRE(engram_command(probe + " --out " + one.path().string()).code == 0);
  std::mt19937 random(6);
  run_shards(probe, 3, many.path(), 0, random);
  const CommandResult merged = engram_command("merge " + many.path().string() + " --json");
  INFO(merged.err);
  REQUIRE(merged.code == 0);
  CHECK(merged.out == read_file(one.path() / "probe.json"));
  CHECK(results_below(many.path()) == results_below(one.path()));
}

TEST_CASE("merge: shards of demonstrations", "[apps][shards]") {
  const std::string collect =
      "collect RememberColor3-VLA-v0 BlinkCountButtonPressEasy-VLA-v0 --episodes 10";
  const TemporaryFolder one;
  const TemporaryFolder many;
  REQUIRE(engram_command(collect + " --out " + one.path().string()).code == 0);
  std::mt19937 random(8);
  run_shards(collect, 3, many.path(), 1, random);
  const CommandResult merged = engram_command("merge " + many.path().string());
  INFO(merged.err);
  REQUIRE(merged.code == 0);
  auto expected = results_below(one.path());
  auto found = results_below(many.path());
  expected.erase("collect_report.html");
  found.erase("collect_report.html");
  CHECK(expected.size() == 22);
  CHECK(found == expected);
  require_refusal(collect + " --format rl --shard 1/2 --out " + many.path().string(), 2, "npz");
}

TEST_CASE("merge: says what is missing, and the commands that play it", "[apps][shards]") {
  const std::string eval = "eval RememberColor3-VLA-v0 --policy oracle --episodes 5";
  const TemporaryFolder folder;
  const std::string out = folder.path().string();
  REQUIRE(engram_command(eval + " --shard 2/3 --out " + out).code == 0);
  const CommandResult missing = engram_command("merge " + out);
  CHECK(missing.code == 1);
  CHECK_THAT(missing.err, Catch::Contains("2 of 3 shards not finished"));
  CHECK_THAT(missing.out, Catch::Contains("engram " + eval + " --shard 1/3 --out " + out +
                                          "  # 2 episodes of shard 1/3") &&
                              Catch::Contains("--shard 3/3"));
  const ParsedJson document = ParsedJson::parse(engram_command("merge --json " + out).out);
  CHECK(document["missing"].size() == 2);
  CHECK(document["missing"][1]["episodes"] == 1);
  for (const ParsedJson& one : document["missing"]) {
    const std::string command = one["command"];
    CHECK(engram_command(command.substr(std::string("engram ").size())).code == 0);
  }
  CHECK(engram_command("merge " + out).code == 0);
}

TEST_CASE("merge: what does not belong together is refused", "[apps][shards]") {
  const std::string eval = "eval RememberColor3-VLA-v0 --policy oracle --shard ";
  const TemporaryFolder folder;
  const std::string out = folder.path().string();
  REQUIRE(engram_command(eval + "1/2 --episodes 2 --out " + out).code == 0);
  REQUIRE(engram_command(eval + "2/2 --episodes 4 --out " + out).code == 0);
  require_refusal("merge " + out, 2, "has n_episodes 2");
  // A shard's folder is of one run, too.
  require_refusal(eval + "2/2 --episodes 2 --out " + out, 2, "has n_episodes 4");
  require_refusal("merge " + TemporaryFolder().path().string(), 2, "a folder of a shard");
  require_refusal(eval + "1/2", 2, "--out DIR needed");
  require_refusal(eval + "3/2 --out " + out, 2, "--shard: '3/2' given");
}

TEST_CASE("merge: shards of two checkpoints are refused, and make nothing", "[apps][shards]") {
  const TemporaryFolder folder;
  const std::string out = folder.path().string();
  for (const char* number : {"1", "2"}) {
    REQUIRE(engram_command("eval RememberColor3-VLA-v0 --policy oracle --episodes 2 --shard " +
                           std::string(number) + "/2 --out " + out)
                .code == 0);
    std::ofstream(folder.path() / ("shard-" + std::string(number) + "-of-2") / "policy.json")
        << R"({"checkpoint": )" << number << "}";
  }
  require_refusal("merge " + out, 1, "the policy tells checkpoint 2, and told 1 before");
  CHECK_FALSE(fs::exists(folder.path() / "short"));

  fs::copy_file(folder.path() / "shard-1-of-2" / "policy.json",
                folder.path() / "shard-2-of-2" / "policy.json",
                fs::copy_options::overwrite_existing);
  REQUIRE(engram_command("merge " + out).code == 0);
  const fs::path run = fs::directory_iterator(folder.path() / "short")->path();
  CHECK(ParsedJson::parse(read_file(run / "policy.json")) == ParsedJson{{"checkpoint", 1}});
}

TEST_CASE("merge: sealed shards stay sealed until their secret is given", "[apps][shards]") {
  const TemporaryFolder folder;
  const std::string out = folder.path().string();
  const std::string secret = " --seed-file " + out + "/seed";
  std::ofstream(folder.path() / "seed") << std::string(40, 'k') << "\n";
  const std::string eval = "eval RememberColor3-VLA-v0 --policy blind --episodes 4" + secret;
  const ParsedJson one = engram_command(eval + " --json").json();
  for (const char* shard : {"1/2", "2/2"}) {
    REQUIRE(engram_command(eval + " --shard " + shard + " --out " + out).code == 0);
  }
  const CommandResult merged = engram_command("merge --json " + out);
  INFO(merged.err);
  REQUIRE(merged.code == 0);
  CHECK(ParsedJson::parse(merged.out)["tasks"][0]["start_seed"].is_null());
  CHECK_THAT(merged.err, Catch::Contains("sealed"));
  std::string run;
  for (const auto& entry : fs::directory_iterator(folder.path() / "short")) {
    run = entry.path().string();
  }
  CHECK(engram_command("eval --json --resume " + run + secret).json() == one);
}

TEST_CASE("eval, probe: interrupted by signals and time limits, they say how to go on",
          "[apps][shards]") {
  const std::string long_eval = "eval RememberColor3-VLA-v0 --policy oracle --episodes 100000 ";
  const TemporaryFolder folder;
  const std::string out = folder.path().string();
  const auto check = [](const CommandResult& result, const std::string& words) {
    INFO(result.err);
    CHECK(result.code == 1);
    CHECK_THAT(result.err, Catch::StartsWith("engram: interrupted by --time-limit; ") &&
                               Catch::Contains(words));
  };
  check(engram_command(long_eval + "--time-limit 1s --out " + out),
        "engram eval --resume " + out + "/short/");
  check(engram_command(long_eval + "--time-limit 1s --shard 1/2 --out " + out),
        "the same command goes on");
  check(
      engram_command("probe RememberColor3-VLA-v0 --episodes 100000 --time-limit 1s --out " + out),
      "engram probe --resume " + out);
  check(engram_command(long_eval + "--time-limit 1s"), "no results were written");
}

TEST_CASE("probe: resumed to the same bytes", "[apps][shards]") {
  const std::string probe = "probe RememberColor3-VLA-v0 --policy blind --episodes 30 --threads 1 ";
  const TemporaryFolder one;
  const TemporaryFolder other;
  REQUIRE(engram_command(probe + "--out " + one.path().string()).code == 0);
  const std::string out = other.path().string();
  for (int kills = 0; kills < 3; ++kills) {
    const bool again = fs::exists(other.path() / "episodes.journal");
    KilledCommand child(again ? "probe --threads 1 --resume " + out : probe + "--out " + out);
    const std::uintmax_t before = again ? fs::file_size(other.path() / "episodes.journal") : 0;
    std::error_code missing;
    while (!child.has_ended()) {
      const std::uintmax_t now = fs::file_size(other.path() / "episodes.journal", missing);
      if (!missing && now > before + 4000) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    child.kill(SIGKILL);
  }
  if (fs::exists(other.path() / "episodes.journal")) {
    REQUIRE(engram_command("probe --resume " + out).code == 0);
  }
  CHECK(results_below(other.path()) == results_below(one.path()));
  require_refusal("probe --resume " + out, 2, "no unfinished probes");
}

// Shards of a run, killed at random moments until they are finished.
void check_kills(const std::string& command, int most) {
  const TemporaryFolder one;
  REQUIRE(engram_command(command + " --out " + one.path().string()).code == 0);
  const auto results = [](const fs::path& folder) {
    auto files = results_below(folder);
    files.erase("collect_report.html");  // has times
    return files;
  };
  const auto expected = results(one.path());
  std::mt19937 random(7);
  std::uniform_int_distribution<int> wait(5, 250);
  int kills = 0;
  while (kills < most) {
    const TemporaryFolder many;
    for (int number = 1; number <= 2; ++number) {
      const std::string line =
          command + " --shard " + std::to_string(number) + "/2 --out " + many.path().string();
      // Longer and longer, for machines on which little is finished in between.
      for (int tries = 0;; ++tries) {
        KilledCommand child(line);
        std::this_thread::sleep_for(std::chrono::milliseconds(wait(random)) * (1 + tries / 8));
        const bool ended = child.has_ended();
        child.kill(SIGKILL);
        if (ended) break;
        ++kills;
      }
    }
    REQUIRE(engram_command("merge " + many.path().string()).code == 0);
    CHECK(results(many.path()) == expected);
  }
}

const std::string kKilledEval =
    "eval RememberColor3-VLA-v0 RememberShape3-VLA-v0 --policy oracle --episodes 40 --threads 1";
const std::string kKilledCollect =
    "collect RememberColor3-VLA-v0 BlinkCountButtonPressEasy-VLA-v0 --episodes 4 --threads 1 "
    "--num-envs 2";

TEST_CASE("eval, collect: shards killed at random moments lose nothing that was finished",
          "[apps][shards]") {
  check_kills(kKilledEval, 4);
  check_kills(kKilledCollect, 4);
}

TEST_CASE("eval, collect: shards killed hundreds of times lose nothing", "[apps][shards][long]") {
  check_kills(kKilledEval, 300);
  check_kills(kKilledCollect, 200);
}

}  // namespace
}  // namespace engram::test
