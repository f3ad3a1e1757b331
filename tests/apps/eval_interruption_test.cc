// `engram eval` killed at any moment, and under mpirun.
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

namespace engram::test {
namespace {

namespace fs = std::filesystem;

const std::string kTasks =
    "RememberColor3-VLA-v0 RememberColor5-VLA-v0 RememberShape3-VLA-v0 TakeItBack-VLA-v0 "
    "InterceptMedium-VLA-v0 RotateLenientPos-VLA-v0 ShellGameTouch-VLA-v0 ShellGamePush-VLA-v0";
const std::string kProtocol = " --policy oracle --episodes 30 --num-envs 4";

std::map<std::string, std::string> results_in(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (entry.path().extension() == ".json" && name != "timing.json") {
      files[name] = read_file(entry.path());
    }
  }
  return files;
}

// The folder that a run with --out has made, or nothing if it was killed before.
fs::path run_in(const fs::path& output) {
  const fs::path split = output / "short";
  if (!fs::exists(split)) return {};
  for (const auto& entry : fs::directory_iterator(split)) {
    if (entry.is_directory()) return entry.path();
  }
  return {};
}

// Starts the command, and kills it some time after the folder has N documents. Returns whether
// it was still running.
bool kill_after(const std::string& arguments, const fs::path& output, std::size_t enough,
                std::chrono::duration<double> time) {
  KilledCommand command(arguments);
  while (files_below(output, ".json") < enough && !command.has_ended()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  std::this_thread::sleep_for(time);
  return command.kill(SIGKILL);
}

}  // namespace

void check_results_after_kills(int most) {
  const TemporaryFolder reference;
  const auto start = std::chrono::steady_clock::now();
  REQUIRE(
      engram_command("eval " + kTasks + kProtocol + " --out " + reference.path().string()).code ==
      0);
  const std::chrono::duration<double> whole = std::chrono::steady_clock::now() - start;
  const auto expected = results_in(run_in(reference.path()));
  REQUIRE(expected.size() == 10);

  std::mt19937 random(20260101);
  // By what has been written: by the clock alone, a first run that was held up makes all others
  // end before they are killed.
  std::uniform_int_distribution<std::size_t> more(0, 4);
  std::uniform_real_distribution<double> share(0, 0.1);
  const std::string command = "eval " + kTasks + kProtocol;
  int killed = 0;
  int partial = 0;
  while (killed < most) {
    const TemporaryFolder folder;
    std::string arguments = command;
    arguments.append(" --out ").append(folder.path().string());
    // Killed once or several times, then left to end.
    fs::path run;
    for (int k = 0; k < 3; ++k) {
      const std::size_t enough = files_below(folder.path(), ".json") + more(random);
      const bool alive = kill_after(arguments, folder.path(), enough, whole * share(random));
      killed += alive ? 1 : 0;
      run = run_in(folder.path());
      if (run.empty()) continue;
      arguments = command;
      arguments.append(" --resume ").append(run.string());
      // Existing files are complete and right.
      const auto present = results_in(run);
      for (const auto& [name, content] : present) {
        if (name != "summary.json") CHECK(content == expected.at(name));
      }
      if (present.size() > 2 && present.size() < expected.size()) ++partial;
    }
    REQUIRE(engram_command(arguments).code == 0);
    CHECK(results_in(run_in(folder.path())) == expected);
    int leftovers = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
      leftovers += entry.path().extension() == ".engram-tmp" ? 1 : 0;
    }
    CHECK(leftovers == 0);
  }
  CHECK(partial > 0);
}

TEST_CASE("eval: killed at random moments, resumed to the same files", "[apps]") {
  check_results_after_kills(5);
}

TEST_CASE("eval: killed many times, resumed to the same files", "[apps][long]") {
  check_results_after_kills(24);
}

TEST_CASE("eval: ranks under mpirun give the same bytes", "[apps]") {
  if (!has_mpi()) {
    WARN("no MPI in this build; nothing checked");
    return;
  }
  const TemporaryFolder folder;
  const std::string arguments = "eval " + kTasks + " --policy random --episodes 7 --json";
  const CommandResult alone = engram_command(arguments);
  REQUIRE(alone.code == 0);
  for (const int count : {1, 2, 3}) {
    const CommandResult result = command_of_ranks(count, arguments);
    INFO(result.err);
    CHECK(result.code == 0);
    CHECK(result.out == alone.out);
  }
  const std::string choices =
      "eval RememberColor3-VLA-v0 --obs objects --episodes 7 --json "
      "--policy-choices '" +
      choices_policy() + " --guess'";
  CHECK(command_of_ranks(2, choices).out == engram_command(choices).out);
  // Errors of the user end all ranks.
  const CommandResult wrong = command_of_ranks(2, "eval NoSuchTask-VLA-v0");
  CHECK(wrong.code != 0);
  CHECK(wrong.code != 124);
  CHECK_THAT(wrong.err, Catch::Contains("NoSuchTask"));

  // A rank that dies ends the run, and what is finished stays.
  const fs::path output = folder.path() / "results";
  const std::string long_run = "eval " + kTasks + " --policy oracle --episodes 200 --num-envs 4";
  std::thread killer([&] {
    // The second rank, once the first task is finished.
    for (int i = 0; i < 2000; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      const fs::path run = run_in(output);
      if (!run.empty() && fs::exists(run / "summary.json")) break;
    }
    (void)std::system(
        ("for p in $(pgrep -f -- '--out " + output.string() +
         "$'); do tr '\\0' '\\n' </proc/$p/environ | grep -qx OMPI_COMM_WORLD_RANK=1 && "
         "kill -9 $p; done")
            .c_str());
  });
  const CommandResult died = command_of_ranks(2, long_run + " --out " + output.string());
  killer.join();
  INFO(died.err);
  CHECK(died.code != 0);
  CHECK(died.code != 124);
  const fs::path run = run_in(output);
  REQUIRE(!run.empty());
  const auto present = results_in(run);
  CHECK(present.size() < 10);
  CHECK(command_of_ranks(3, "eval --resume " + run.string()).code == 0);
  const CommandResult whole = engram_command(long_run + " --json");
  const ParsedJson summary = whole.json();
  for (const ParsedJson& task : summary["tasks"]) {
    const std::string name = task["env_id"].get<std::string>() + ".json";
    CHECK(read_file(run / name) == task.dump(2) + "\n");
  }
}

}  // namespace engram::test
