#include "apps/eval_options.h"

#include <catch2/catch.hpp>

namespace engram::apps {
namespace {

EvalOptions options_of(const std::vector<std::string>& words) {
  EvalOptions options;
  CommandLine line("engram", "");
  const Command command = line.program().add_command("eval", "");
  add_eval_options(command, options);
  command.on_run([] {});
  std::vector<std::string> all = {"eval"};
  all.insert(all.end(), words.begin(), words.end());
  line.parse(all);
  return options;
}

TEST_CASE("Settings of an evaluation come from the command line", "[apps][evaluation]") {
  const EvalOptions options = options_of({"TakeItBack-VLA-v0", "RememberColor3-VLA-v0",
                                          "--episodes", "7", "--seed", "3", "--obs", "state"});
  const EvaluationSettings settings = settings_of(options);
  CHECK(settings.tasks == std::vector<std::string>{"RememberColor3-VLA-v0", "TakeItBack-VLA-v0"});
  CHECK(settings.episodes == 7);
  CHECK(settings.start_seed == 3);
  CHECK(settings.obs_mode == ObsMode::kState);
  CHECK(settings.renderer == "none");
  CHECK(settings.policy == "oracle");
  CHECK(options.given.contains("n_episodes"));
  CHECK_FALSE(options.given.contains("rules"));
}

TEST_CASE("An evaluation needs tasks, chosen in one way", "[apps][evaluation]") {
  CHECK_THROWS_AS(settings_of(options_of({})), Error);
  CHECK_THROWS_AS(settings_of(options_of({"RememberColor3-VLA-v0", "--all"})), Error);
}

TEST_CASE("A protocol runs the policy of the settings only", "[apps][evaluation]") {
  EvalOptions options = options_of({"RememberColor3-VLA-v0", "--policy", "blind"});
  EvaluationSettings settings = settings_of(options);
  CHECK(protocol_of(options, settings).policy == Policy::kBlind);
  CHECK_FALSE(protocol_of(options, settings).samples);
  settings.policy = "no_such_policy";
  CHECK_THROWS_WITH(protocol_of(options, settings), Catch::Contains("no_such_policy"));
  settings.policy_config = JsonTable{{"command", "x"}};
  CHECK_THROWS_WITH(protocol_of(options, settings), Catch::Contains("not the command"));
}

}  // namespace
}  // namespace engram::apps
