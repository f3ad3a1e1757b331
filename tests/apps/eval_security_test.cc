// `engram eval` among folders, commands and processes that are not what they seem.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "protocol/eval/results/result_files.h"
#include "tests/apps/command.h"

namespace engram::test {
namespace {

namespace fs = std::filesystem;

const std::string kEval = "eval RememberColor3-VLA-v0 --episodes 2 --obs state ";

// The only folder two levels below.
fs::path run_in(const fs::path& output) {
  const fs::path split = fs::directory_iterator(output)->path();
  return fs::directory_iterator(split)->path();
}

std::string with_command(const std::string& command) {
  return " --policy-command '" + command + "' ";
}

}  // namespace

TEST_CASE("command: an empty text is refused by every option", "[apps]") {
  const std::string task = " RememberColor3-VLA-v0 ";
  for (const std::string& options :
       {"eval" + task + "--policy-command ''",
        "eval" + task + "--policy-command=", "eval" + task + "--out ''",
        "eval" + task + "--out= --json", std::string("eval --resume ''"),
        "record" + task + "--out ''", "record" + task + "--out a.png --policy-command ''",
        "collect" + task + "--out ''", "info" + task + "--mjcf ''", std::string("list --family ''"),
        std::string("rollout ''"), std::string("eval ''")}) {
    require_refusal(options, 2, ": '' given, a text needed");
  }
}

TEST_CASE("command: a policy name needs an external policy", "[apps]") {
  for (const char* command : {"eval", "record --out a.png"}) {
    const std::string given = command + std::string(" RememberColor3-VLA-v0 ");
    require_refusal(given + "--policy-name mine", 2, "--policy-name requires --policy-command");
    require_refusal(given + "--policy-timeout 5", 2, "--policy-timeout requires --policy-command");
    require_refusal(given + "--policy oracle --policy-name mine", 2, "requires --policy-command");
  }
}

TEST_CASE("eval: a folder cannot name the command to run", "[apps]") {
  const TemporaryFolder folder;
  const std::string ran = (folder.path() / "ran").string();
  REQUIRE(engram_command(kEval + "--policy zero --out " + folder.path().string() + "/r").code == 0);
  const fs::path run = run_in(folder.path() / "r");
  const ParsedJson own = ParsedJson::parse(read_file(run / "settings.json"));
  ParsedJson theirs = own;
  theirs["policy"] = "external";
  theirs["policy_config"] = {{"command", "touch " + ran + "; exit 3"}};
  fs::remove(run / "RememberColor3-VLA-v0.json");
  const std::string resume = "eval --resume " + run.string();
  const auto refuse = [&](const std::string& options, const std::string& words) {
    require_refusal(resume + options, 2, words);
    CHECK_FALSE(fs::exists(ran));
  };
  for (const char* name : {"external", "zero"}) {
    theirs["policy"] = name;
    std::ofstream(run / "settings.json") << with_checksum(theirs);
    refuse("", "the same --policy-command needed");
    refuse(" --policy zero", name == std::string("zero") ? "--policy-command needed" : "\"zero\"");
    refuse(with_command("exit 0"), "{\"command\":\"exit 0\"} given now");
    refuse(with_command("touch " + ran), "given now");
  }
  // Given again, it is the user's word.
  require_refusal(resume + with_command("touch " + ran + "; exit 3"), 1, "exit code 3");
  CHECK(fs::remove(ran));
  // A command in place of a policy of engram's own.
  std::ofstream(run / "settings.json") << with_checksum(own);
  refuse(with_command(pipe_policy()), "policy_config null");
  CHECK(engram_command(resume).code == 0);
}

TEST_CASE("eval: a run with an external policy continues with the same command", "[apps]") {
  const TemporaryFolder folder;
  const std::string policy = with_command(pipe_policy()) + "--policy-name pipes ";
  const CommandResult whole =
      engram_command(kEval + policy + "--json --out " + folder.path().string());
  const ParsedJson task = whole.json()["tasks"][0];
  CHECK(task["version"] ==
        ParsedJson::parse(read_file(run_in(folder.path()) / "settings.json"))["version"]);
  CHECK(task["model"]["name"] == "pipes");
  fs::remove(run_in(folder.path()) / "RememberColor3-VLA-v0.json");
  const std::string resume = "eval --json --resume " + run_in(folder.path()).string();
  require_refusal(resume, 2, "the same --policy-command needed");
  CHECK(engram_command(resume + with_command(pipe_policy())).out == whole.out);
}

TEST_CASE("eval: a second run in a folder is refused with the owner's name", "[apps]") {
  const TemporaryFolder folder;
  REQUIRE(engram_command(kEval + "--policy zero --out " + folder.path().string()).code == 0);
  const fs::path run = run_in(folder.path());
  {
    const ResultFolder held = ResultFolder::open(run);
    require_refusal("eval --resume " + run.string(), 1,
                    "is in use by process " + std::to_string(::getpid()));
  }
  CHECK(engram_command("eval --resume " + run.string()).code == 0);
}

TEST_CASE("eval: many runs at once in one folder do no harm", "[apps]") {
  const TemporaryFolder folder;
  const std::string tasks = "eval RememberColor3-VLA-v0 RememberColor5-VLA-v0 ";
  REQUIRE(
      engram_command(tasks + "--policy zero --episodes 2 --out " + folder.path().string()).code ==
      0);
  const fs::path run = run_in(folder.path());
  const std::string whole = read_file(run / "RememberColor3-VLA-v0.json");
  fs::remove(run / "RememberColor3-VLA-v0.json");
  std::vector<CommandResult> results(6);
  std::vector<std::thread> threads;
  threads.reserve(results.size());
  for (CommandResult& result : results) {
    threads.emplace_back(
        [&result, &run] { result = engram_command("eval --threads 1 --resume " + run.string()); });
  }
  for (std::thread& thread : threads) thread.join();
  int finished = 0;
  for (const CommandResult& result : results) {
    finished += result.code == 0 ? 1 : 0;
    if (result.code != 0) CHECK_THAT(result.err, Catch::Contains("is in use by"));
  }
  CHECK(finished >= 1);
  CHECK(read_file(run / "RememberColor3-VLA-v0.json") == whole);
  for (const auto& entry : fs::recursive_directory_iterator(run)) {
    CHECK(entry.path().extension() != ".engram-tmp");
  }
}

TEST_CASE("command: foreign text reaches the terminal escaped", "[apps]") {
  const auto shown = [](const std::string& arguments) {
    const CommandResult result = engram_command(arguments);
    for (const char c : result.out + result.err) {
      CHECK((static_cast<unsigned char>(c) >= ' ' || c == '\n'));
    }
    return result.out + result.err;
  };
  const std::string escape = "\"$(printf '\\033]0;title\\007')\"";
  CHECK_THAT(shown("info " + escape), Catch::Contains("\\u001b]0;title\\u0007"));
  CHECK_THAT(shown(kEval + "--policy-command 'exit 3 #'" + escape),
             Catch::Contains("\\u001b]0;title"));
  // A policy that fails with a message of its own.
  const std::string failing = R"('printf "\5\0\0\0\4\0\0\0\033[2J"; cat >/dev/null')";
  CHECK_THAT(shown(kEval + "--policy-command " + failing), Catch::Contains("says: \\u001b[2J"));
  const TemporaryFolder folder;
  const std::string out = "--policy zero --out " + folder.path().string() + "/" + escape;
  CHECK_THAT(shown(kEval + out), Catch::Contains("/\\u001b]0;title\\u0007/short/"));
}

TEST_CASE("eval: an interrupted run ends without waiting for busy threads", "[apps]") {
  const std::string run = "eval --all --policy zero --episodes 2000 --num-envs 2 --threads 300";
  // The signal comes once there are threads; each of them makes a batch, which takes long together.
  const std::string line =
      "& p=$!; while [ -d /proc/$p ] && [ $(ls /proc/$p/task | wc -l) -lt 300 ]; do sleep 0.05; "
      "done; kill -TERM $p; wait $p";
  const CommandResult result = engram_command(run, line);
  CHECK(result.code == 1);
  CHECK_THAT(result.err, Catch::StartsWith("engram: interrupted; "));
}

}  // namespace engram::test
