// `engram reproduce`: episodes of a run, played again.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/apps/command.h"

namespace engram::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTask = "RememberColor3-VLA-v0";

// The folder of a finished run.
fs::path finished_run(const TemporaryFolder& folder, const std::string& options) {
  const CommandResult result =
      engram_command("eval --episodes 3 --out " + folder.path().string() + " " + options);
  INFO(result.err);
  REQUIRE(result.code == 0);
  return fs::directory_iterator(fs::directory_iterator(folder.path())->path())->path();
}

// What the command prints as JSON, which has exit code 1 where something differs.
ParsedJson reproduced(const fs::path& run, const std::string& options = "") {
  const CommandResult result =
      engram_command("reproduce " + run.string() + " --json --episodes 2 " + options);
  INFO(result.err);
  const ParsedJson document = ParsedJson::parse(result.out);
  CHECK(result.code == (document["verdict"] == "same" ? 0 : 1));
  return document;
}

TEST_CASE("reproduce: a run is the same again, for each of its settings", "[apps]") {
  for (const char* options :
       {"RememberColor3-VLA-v0 TakeItBack-VLA-v0", "RememberColor3-VLA-v0 --obs rgb --seed 7",
        "RememberColor3-VLA-v0 --policy blind --repeat 2 --policy-seed 3 --latency 2",
        "RememberColor3-VLA-v0 --physics mujoco --rules original"}) {
    INFO(options);
    const TemporaryFolder folder;
    const ParsedJson document = reproduced(finished_run(folder, options));
    CHECK(document["verdict"] == "same");
    CHECK(document["policy_repeats"].is_null());
    const ParsedJson& comparison = document["comparison"];
    CHECK(comparison["total"]["pairs"] == 2 * comparison["tasks"].size());
  }
}

TEST_CASE("reproduce: another policy is not another environment", "[apps]") {
  const TemporaryFolder folder;
  const fs::path run = finished_run(folder, kTask);
  const ParsedJson blind = reproduced(run, "--policy blind");
  CHECK(blind["verdict"] == "policy");
  CHECK(blind["policy_repeats"] == true);
  const fs::path file = run / (std::string(kTask) + ".json");
  const ParsedJson genuine = ParsedJson::parse(read_file(file));
  const auto with = [&](const char* key, std::size_t episode) {
    ParsedJson task = genuine;
    task["digests"][key][episode] = "0123456789abcdef";
    std::ofstream(file) << with_checksum(task);
    return reproduced(run)["verdict"];
  };
  CHECK(with("first_observations", 1) == "environment");
  CHECK(with("first_observations", 2) == "same");  // not among the episodes that are played
  CHECK(with("observations", 0) == "environment");
  CHECK(with("first_answers", 0) == "policy");
  CHECK(with("answers", 0) == "policy");
}

// A policy that tells its checkpoint before its first answer.
std::string told_by(const TemporaryFolder& folder, const std::string& checkpoint) {
  const fs::path file = folder.path() / "telling.py";
  std::ofstream(file) << "import os, sys\n"
                         "sys.path.insert(0, '" +
                             (fs::path(test::kRoot) / "python" / "examples").string() +
                             "')\n"
                             "import pipe_policy\n"
                             "pipe_policy.send(9, b'{\"checkpoint\": \"' + sys.argv[1].encode() + "
                             "b'\"}')\n"
                             "try:\n"
                             "    pipe_policy.main()\n"
                             "except BrokenPipeError:  # the command has ended\n"
                             "    os._exit(1)\n";
  return " --policy-command 'python3 -B " + file.string() + " " + checkpoint + "'";
}

TEST_CASE("reproduce: a policy that tells another checkpoint is another one", "[apps]") {
  const TemporaryFolder folder;
  const TemporaryFolder scripts;
  const std::string first = told_by(scripts, "first");
  const fs::path run = finished_run(folder, kTask + first);
  CHECK(ParsedJson::parse(read_file(run / "policy.json")) == ParsedJson{{"checkpoint", "first"}});

  const ParsedJson same = reproduced(run, first);
  CHECK(same["verdict"] == "same");
  CHECK(same["checkpoints"] == ParsedJson{{"run", "first"}, {"again", "first"}});
  // The answers are the same, as far as they are known.
  const ParsedJson other = reproduced(run, told_by(scripts, "second"));
  CHECK(other["verdict"] == "policy");
  CHECK(other["policy_repeats"].is_null());
  CHECK(other["checkpoints"] == ParsedJson{{"run", "first"}, {"again", "second"}});
  CHECK(engram_command("reproduce " + run.string() + told_by(scripts, "second"))
            .out.find("the policy differs; it tells checkpoint \"second\" here, and told "
                      "\"first\" in the run") != std::string::npos);
  const ParsedJson silent = reproduced(run, " --policy-command '" + pipe_policy() + "'");
  CHECK(silent["verdict"] == "same");
  CHECK(silent["checkpoints"]["again"].is_null());
}

TEST_CASE("eval: a run goes on with its checkpoint alone", "[apps]") {
  const TemporaryFolder folder;
  const TemporaryFolder scripts;
  const fs::path checkpoint = scripts.path() / "name";
  // Its command stays equal while the checkpoint changes.
  const std::string command = told_by(scripts, "\"$(cat " + checkpoint.string() + ")\"");
  std::ofstream(checkpoint) << "first";
  const fs::path run = finished_run(folder, kTask + command);
  fs::remove(run / (std::string(kTask) + ".json"));
  std::ofstream(checkpoint) << "second";
  const std::string resume = "eval --resume " + run.string() + command;
  require_refusal(resume, 1, "tells checkpoint \"second\", and told \"first\" before");
  std::ofstream(checkpoint) << "first";
  CHECK(engram_command(resume).code == 0);
}

TEST_CASE("reproduce: refusals", "[apps]") {
  const TemporaryFolder folder;
  const fs::path run = finished_run(folder, kTask);
  const std::string command = "reproduce " + run.string();
  require_refusal(command + " TakeItBack-VLA-v0", 2, "TakeItBack-VLA-v0 given");
  require_refusal("reproduce " + folder.path().string(), 2, "it has no settings");
  ParsedJson settings = ParsedJson::parse(read_file(run / "settings.json"));
  settings["policy_config"] = {{"command", "exit 3"}};
  std::ofstream(run / "settings.json") << with_checksum(settings);
  require_refusal(command, 2, "the same --policy-command needed");
  settings["version"] = "0.1.0";
  std::ofstream(run / "settings.json") << with_checksum(settings);
  require_refusal(command, 1, "0.1.0");
}

}  // namespace
}  // namespace engram::test
