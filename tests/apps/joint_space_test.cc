// Control modes of joints, proprio of joints and named lists of tasks in the commands.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "tests/apps/command.h"
#include "tests/build_paths.h"

namespace engram::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kId = "RememberColor3-VLA-v0";

// A pipe policy that answers zeros, and requires the numbers of the greeting to be these.
std::string policy_for(int proprio, int action) {
  const auto examples = fs::path(test::kRoot) / "python" / "examples";
  const std::string dim = std::to_string(action);
  return " --policy-command 'python3 -c \"import sys; sys.path.insert(0, \\\"" + examples.string() +
         "\\\"); import pipe_policy; "
         "pipe_policy.act = lambda task, asked: [((1, " +
         dim + "), [0.0] * " + dim +
         ")] * asked[\\\"count\\\"] if memoryview(asked[\\\"proprio\\\"]).nbytes == 4 * " +
         std::to_string(proprio) + " * asked[\\\"count\\\"] else []; pipe_policy.main()\"'";
}

}  // namespace

TEST_CASE("eval: the oracle succeeds in joint space, and results tell the mode", "[apps]") {
  const std::string command =
      std::string("eval ") + kId + " ShellGamePush-VLA-v0 --episodes 6 --json ";
  const ParsedJson usual = engram_command(command).json();
  const ParsedJson joints =
      engram_command(command + "--control-mode pd_joint_pos --joint-proprio").json();
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(usual["tasks"][i]["control_mode"] == "pd_ee_delta_pose");
    CHECK_FALSE(usual["tasks"][i].contains("joint_proprio"));
    CHECK(joints["tasks"][i]["control_mode"] == "pd_joint_pos");
    CHECK(joints["tasks"][i]["joint_proprio"] == true);
    CHECK(joints["tasks"][i]["successes"] == usual["tasks"][i]["successes"]);
    CHECK(joints["tasks"][i]["episode_lengths"] == usual["tasks"][i]["episode_lengths"]);
    CHECK(joints["tasks"][i]["digests"] != usual["tasks"][i]["digests"]);
  }
  const CommandResult other = engram_command(command + "--control-mode pd_ee_pose");
  CHECK(other.code == 2);
  CHECK_THAT(other.err, Catch::Contains("oracle with control mode pd_ee_pose, pd_ee_delta_pose, "
                                        "pd_joint_pos or pd_joint_delta_pos needed"));
}

TEST_CASE("eval: external policies are told the numbers of proprio and action", "[apps]") {
  const std::string command = std::string("eval ") + kId + " --episodes 2 --json --obs state ";
  CHECK(engram_command(command + policy_for(7, 7)).code == 0);
  CHECK(engram_command(command + "--control-mode pd_joint_delta_pos" + policy_for(7, 8)).code == 0);
  CHECK(engram_command(command + "--joint-proprio" + policy_for(8, 7)).code == 0);
  const CommandResult wrong =
      engram_command(command + "--control-mode pd_joint_pos" + policy_for(7, 7));
  CHECK(wrong.code == 1);
  CHECK_THAT(wrong.err, Catch::Contains("actions of shape (1, 7) given, (8), (K, 8) or (1, K, 8)"));
}

TEST_CASE("eval: a run is not resumed in another control mode", "[apps]") {
  const TemporaryFolder folder;
  const std::string command =
      std::string("eval ") + kId + " --episodes 2 --control-mode pd_joint_pos ";
  REQUIRE(engram_command(command + "--out " + folder.path().string()).code == 0);
  const fs::path run = fs::directory_iterator(folder.path() / "short")->path();
  CHECK(engram_command("eval --resume " + run.string()).code == 0);
  const CommandResult other =
      engram_command("eval --control-mode pd_joint_delta_pos --resume " + run.string());
  CHECK(other.code == 2);
  CHECK_THAT(other.err,
             Catch::Contains("control_mode \"pd_joint_pos\"; \"pd_joint_delta_pos\" given now"));
}

TEST_CASE("eval: a suite has its tasks and its number of episodes", "[apps]") {
  const ParsedJson few = engram_command("eval --suite mikasa5 --episodes 1 --json").json();
  REQUIRE(few["tasks"].size() == 5);
  CHECK(few["tasks"][0]["episode_seeds"] == ParsedJson({4242424242}));
  std::vector<std::string> ids;
  for (const ParsedJson& task : few["tasks"]) ids.push_back(task["env_id"]);
  CHECK(ids == std::vector<std::string>{"ShellGameTouch-VLA-v0", "RememberColor3-VLA-v0",
                                        "RememberColor5-VLA-v0", "RememberColor9-VLA-v0",
                                        "InterceptMedium-VLA-v0"});
  const ParsedJson all = engram_command("eval --suite mikasa5 --json").json();
  for (const ParsedJson& task : all["tasks"]) CHECK(task["n_episodes"] == 100);

  const CommandResult unknown = engram_command("eval --suite mikasa6");
  CHECK(unknown.code == 2);
  CHECK_THAT(unknown.err, Catch::Contains("--suite: 'mikasa6' given, mikasa5 allowed"));
  const CommandResult both = engram_command(std::string("eval --suite mikasa5 ") + kId);
  CHECK(both.code == 2);
  CHECK_THAT(both.err, Catch::Contains("one or the other allowed"));
}

TEST_CASE("collect: folders have one control mode", "[apps]") {
  const TemporaryFolder folder;
  const std::string command =
      "collect RememberColor3-VLA-v0 --episodes 2 --out " + folder.path().string() + " ";
  REQUIRE(engram_command(command + "--control-mode pd_joint_pos --joint-proprio").code == 0);
  const fs::path path = folder.path() / "data_npz" / kId;
  const ParsedJson metadata = ParsedJson::parse(read_file(path / "metadata.json"));
  CHECK(metadata["engram"]["control_mode"] == "pd_joint_pos");
  CHECK(metadata["engram"]["joint_proprio"] == true);
  const CommandResult other = engram_command(command + "--joint-proprio");
  CHECK(other.code == 2);
  CHECK_THAT(other.err, Catch::Contains("was collected with control_mode \"pd_joint_pos\""));
  const CommandResult shorter = engram_command(command + "--control-mode pd_joint_pos");
  CHECK(shorter.code == 2);
  CHECK_THAT(shorter.err, Catch::Contains("was collected with joint_proprio true"));
  const TemporaryFolder empty;
  const CommandResult refused = engram_command(
      "collect RememberColor3-VLA-v0 --control-mode pd_ee_pose --out " + empty.path().string());
  CHECK(refused.code == 2);
  CHECK_FALSE(fs::exists(empty.path() / "data_npz"));
}

TEST_CASE("verify: joint space repeats bit for bit", "[apps]") {
  const std::string command = std::string("verify ") + kId + " --steps 2 --obs rgb --json ";
  const ParsedJson usual = engram_command(command).json();
  const ParsedJson joints =
      engram_command(command + "--control-mode pd_joint_delta_pos --joint-proprio").json();
  CHECK(joints[0]["different"] == 0);
  CHECK(joints[0]["fingerprint"] != usual[0]["fingerprint"]);
}

TEST_CASE("record: the oracle acts in joint space", "[apps]") {
  const TemporaryFolder folder;
  const auto report = [&folder](const std::string& options) {
    return engram_command("record ShellGameTouch-VLA-v0 --size 64 --json --out " +
                          (folder.path() / "a.gif").string() + " " + options)
        .json();
  };
  const ParsedJson usual = report("");
  const ParsedJson joints = report("--control-mode pd_joint_pos --joint-proprio");
  CHECK(joints["success_once"] == true);
  CHECK(joints["frames"] == usual["frames"]);
}

}  // namespace engram::test
