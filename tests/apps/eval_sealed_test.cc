// `engram eval --seed-file`: nobody knows the seeds before the end.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/base/sha256.h"
#include "protocol/eval/policies/seed_commitment.h"
#include "tests/apps/command.h"

namespace engram::test {
namespace {

namespace fs = std::filesystem;

const std::string kId = "RememberColor3-VLA-v0";
const std::string kSecret = "the-secret-of-a-test-0123456789abcdef\n";

// The only folder two levels below.
fs::path run_in(const fs::path& output) {
  const fs::path split = fs::directory_iterator(output)->path();
  return fs::directory_iterator(split)->path();
}

struct Sealed {
  TemporaryFolder folder;
  std::string seed_file = (folder.path() / "seed").string();
  std::string out = (folder.path() / "results").string();

  Sealed() { std::ofstream(seed_file) << kSecret; }
};

// The policy of eval_rebuilding_policy_test.cc.
std::string cheat() {
  const std::string program = fs::read_symlink("/proc/self/exe").string();
  return " --obs objects --policy-command \"'" + program +
         "' '[.rebuilding-policy]' -o /dev/null\" ";
}

ParsedJson only_task(const std::string& arguments) {
  return engram_command(arguments).json()["tasks"][0];
}

}  // namespace

TEST_CASE("eval: a policy that rebuilds its episodes scores chance in a sealed run", "[apps]") {
  const Sealed sealed;
  const std::string eval = "eval " + kId + " --json " + cheat();
  // Public seeds are known by heart, whether numbers are told or not.
  CHECK(only_task(eval + "--tell-episodes")["sr"] == 1.0);
  CHECK(only_task(eval)["sr"] == 1.0);
  const ParsedJson task = only_task(eval + "--seed-file " + sealed.seed_file);
  CHECK(task["n_episodes"] == 50);
  // Three standard deviations above chance.
  CHECK(task["sr"].get<double>() <= 1.0 / 3 + 3 * 0.067);
  CHECK(task["first_answer_correct"].get<double>() <= 1.0 / 3 + 3 * 0.067);
}

TEST_CASE("eval: a sealed run is that of the seed which its secret makes", "[apps]") {
  const Sealed sealed;
  const std::string eval = "eval " + kId + " --json --episodes 3 ";
  const ParsedJson task = only_task(eval + "--seed-file " + sealed.seed_file);
  const std::uint64_t seed = SeedCommitment(kSecret).start_seed();
  const ParsedJson plain = only_task(eval + "--seed " + std::to_string(seed));
  for (const char* key : {"start_seed", "episode_seeds", "successes", "returns", "sr"}) {
    INFO(key);
    CHECK(task[key] == plain[key]);
  }
  CHECK(task["start_seed"] == seed);
  CHECK(task["sealed"]["sha256"] == to_hex(sha256(kSecret)));
  CHECK(task["sealed"]["secret"] == kSecret);
  CHECK_FALSE(plain.contains("sealed"));
}

TEST_CASE("eval: until the end of a sealed run nothing tells its seeds", "[apps]") {
  const Sealed sealed;
  const std::string seen = (sealed.folder.path() / "seen").string();
  // What the policy can read: arguments and environment of engram, and its results.
  const std::string spy = "cat /proc/\\$PPID/cmdline /proc/\\$PPID/environ >" + seen +
                          " 2>/dev/null; cat " + sealed.out + "/*/*/* >>" + seen +
                          " 2>/dev/null; ls -l /proc/self/fd >>" + seen + "; exec " + pipe_policy();
  const std::string arguments = "eval " + kId +
                                " RememberColor5-VLA-v0 --episodes 2 --threads 1 --obs state "
                                "--keep-sealed --seed-file /dev/fd/9 --out " +
                                sealed.out + " --policy-command \"" + spy + "\"";
  const CommandResult result = engram_command(arguments, "9<" + sealed.seed_file);
  INFO(result.err);
  REQUIRE(result.code == 0);
  const std::string secret = kSecret.substr(0, kSecret.size() - 1);
  const std::string seed = std::to_string(SeedCommitment(kSecret).start_seed());
  const std::string spied = read_file(seen);
  CHECK_THAT(spied, Catch::Contains("--seed-file"));
  CHECK_THAT(spied, !Catch::Contains(secret) && !Catch::Contains(seed) &&
                        !Catch::Contains(sealed.seed_file));
  const fs::path run = run_in(sealed.out);
  for (const auto& entry : fs::directory_iterator(run)) {
    if (!entry.is_regular_file()) continue;
    INFO(entry.path());
    CHECK_THAT(read_file(entry.path()), !Catch::Contains(secret) && !Catch::Contains(seed));
  }
  const ParsedJson settings = ParsedJson::parse(read_file(run / "settings.json"));
  CHECK(settings["start_seed"].is_null());
  CHECK(settings["sealed"]["sha256"] == to_hex(sha256(kSecret)));
  const ParsedJson task = ParsedJson::parse(read_file(run / (kId + ".json")));
  CHECK(task["episode_seeds"].is_null());
}

TEST_CASE("eval: a sealed run is resumed with its secret, and opened at the end", "[apps]") {
  const Sealed sealed;
  const std::string ids = kId + " RememberColor5-VLA-v0 ";
  REQUIRE(engram_command("eval " + ids + "--episodes 2 --keep-sealed --seed-file " +
                         sealed.seed_file + " --out " + sealed.out)
              .code == 0);
  const fs::path run = run_in(sealed.out);
  const std::string closed = read_file(run / (kId + ".json"));
  const std::string settings = read_file(run / "settings.json");
  fs::remove(run / "RememberColor5-VLA-v0.json");
  const std::string resume = "eval --resume " + run.string();
  require_refusal(resume, 2, "a sealed run; its --seed-file needed");
  require_refusal(resume + " --seed 4", 2, "sealed run");
  const std::string other = (sealed.folder.path() / "other").string();
  std::ofstream(other) << std::string(40, 'x');
  require_refusal(resume + " --seed-file " + other, 2, to_hex(sha256(kSecret)));
  CHECK(read_file(run / (kId + ".json")) == closed);

  const ParsedJson revealed =
      engram_command(resume + " --json --seed-file " + sealed.seed_file).json();
  const std::uint64_t seed = SeedCommitment(kSecret).start_seed();
  CHECK(revealed["tasks"][0]["episode_seeds"] == std::vector<std::uint64_t>{seed, seed + 1});
  CHECK(revealed["tasks"].size() == 2);
  CHECK(ParsedJson::parse(read_file(run / (kId + ".json"))) == revealed["tasks"][0]);
  // Now anybody can read it, and go on without the file.
  CHECK(engram_command(resume + " --json").json() == revealed);
  // A run that was killed while it opened its results goes on.
  std::ofstream(run / (kId + ".json")) << closed;
  std::ofstream(run / "settings.json") << settings;
  CHECK(engram_command(resume + " --json --seed-file " + sealed.seed_file).json() == revealed);
  CHECK(ParsedJson::parse(read_file(run / (kId + ".json"))) == revealed["tasks"][0]);
}

TEST_CASE("eval: what a sealed run needs is said", "[apps]") {
  const Sealed sealed;
  const std::string eval = "eval " + kId + " --episodes 1 ";
  require_refusal(eval + "--seed 3 --seed-file " + sealed.seed_file, 2,
                  "--seed excludes --seed-file");
  require_refusal(eval + "--keep-sealed", 2, "--keep-sealed requires --seed-file");
  require_refusal(eval + "--tell-episodes", 2, "--tell-episodes requires --policy-command");
  require_refusal(eval + "--seed-file /nowhere/seed", 1, "'/nowhere/seed' does not exist");
  require_refusal(eval + "--seed-file /dev/fd/77", 1, "/dev/fd/77");
  std::ofstream(sealed.seed_file) << "4242\n";
  require_refusal(eval + "--seed-file " + sealed.seed_file, 2, "4 characters given");
  require_refusal(
      eval + "--tell-episodes --policy-command 'exit 3' --seed-file " + sealed.seed_file, 2,
      "one of them allowed");
}

TEST_CASE("eval: told episodes are named in the results", "[apps]") {
  const std::string eval =
      "eval " + kId + " --json --episodes 1 --obs state --policy-command '" + pipe_policy() + "' ";
  CHECK(only_task(eval + "--tell-episodes")["tell_episodes"] == true);
  CHECK_FALSE(only_task(eval).contains("tell_episodes"));
}

}  // namespace engram::test
