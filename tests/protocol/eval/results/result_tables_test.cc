#include "protocol/eval/results/result_tables.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/protocol/eval/results/evaluation_documents.h"

namespace engram {
namespace {

using Catch::Contains;
using test::task_of;

const std::vector<std::string> kFive = {"ShellGameTouch-VLA-v0", "InterceptMedium-VLA-v0",
                                        "RememberColor3-VLA-v0", "RememberColor5-VLA-v0",
                                        "RememberColor9-VLA-v0"};

JsonList some_tasks() {
  return {task_of("RememberColor3-VLA-v0", {true, true, true, false}),
          task_of("SeqOfColors3-Long-VLA-v0", {true, false, false, false})};
}

JsonList five_tasks(int episodes) {
  JsonList tasks;
  for (const std::string& id : kFive) {
    std::vector<bool> successes(static_cast<std::size_t>(episodes));
    std::fill_n(successes.begin(), 10, true);
    tasks.push_back(task_of(id, successes));
  }
  return tasks;
}

std::ptrdiff_t lines_of(const std::string& text) { return std::ranges::count(text, '\n'); }

TEST_CASE("Markdown has a row per task, per split and for all", "[evaluation][results]") {
  const std::string text = result_table(TableFormat::kMarkdown, some_tasks());
  CHECK_THAT(text, Catch::StartsWith("| task | split | success | 95 % interval | chance | score | "
                                     "episodes |\n| --- | --- | ---: | ---: |"));
  CHECK_THAT(text, Contains("| RememberColor3-VLA-v0 | Short | 0.750 | 0.30-0.95 |"));
  CHECK_THAT(text, Contains("| mean of 1 | Long | 0.250 | 0.05-0.70 |"));
  CHECK_THAT(text, Contains("| mean of 2 | all | 0.500 |"));
  CHECK(lines_of(text) == 7);
  // One split needs no row for all.
  CHECK(lines_of(result_table(TableFormat::kMarkdown, {some_tasks()[0]})) == 4);
}

TEST_CASE("LaTeX is a table of booktabs with escaped texts", "[evaluation][results]") {
  const std::string text = result_table(TableFormat::kLatex, some_tasks());
  CHECK_THAT(text, Catch::StartsWith("\\begin{tabular}{llrrrrr}\n\\toprule\n") &&
                       Catch::EndsWith("\\bottomrule\n\\end{tabular}\n"));
  CHECK_THAT(text, Contains("95 \\% interval") && Contains("RememberColor3-VLA-v0 & Short & 0.750 "
                                                           "& 0.30-0.95"));
  CHECK(std::ranges::count(text, '&') == 6 * 6);
}

TEST_CASE("Tables of episodes have their seeds and digests", "[evaluation][results]") {
  EvaluationSettings settings;
  settings.repeat = 2;
  settings.policy_seed = 8;
  settings.start_seed = 100;
  const JsonList tasks = {task_of("RememberColor3-VLA-v0", {true, true, true, false}, settings)};
  const std::string text = episodes_csv(tasks);
  CHECK_THAT(text, Catch::StartsWith("env_id,split,memory_type,episode,seed,policy_seed,success,"));
  CHECK_THAT(text,
             Contains("\nRememberColor3-VLA-v0,Short,Object,0,100,8,true,0.5,10,,,"
                      "0000000000000000,0000000000000001\n") &&
                 Contains("Object,3,101,9,false,0.5,10,,,0000000000000003,0000000000000002\n"));
  CHECK(lines_of(text) == 5);
  CHECK(result_table(TableFormat::kEpisodes, tasks) == text);
  CHECK(lines_of(result_table(TableFormat::kCsv, tasks)) == 2);
  CHECK_THROWS_WITH(result_table(TableFormat::kCsv, {}), Contains("without a task"));
}

TEST_CASE("vla-eval's entry has a mean for its five tasks and 100 episodes",
          "[evaluation][results]") {
  const auto entry = [](const JsonList& tasks) {
    return parse_json(result_table(TableFormat::kVlaEval, tasks)).value();
  };
  const Json whole = entry(five_tasks(100));
  CHECK(number(part(whole, "overall_score")) == 10);
  CHECK(text(part(whole, "benchmark")) == "mikasa");
  CHECK(table(part(whole, "task_scores")).size() == 5);
  CHECK(number(part(part(whole, "task_scores"), "ShellGameTouch")) == 10);
  CHECK_THAT(text(part(whole, "notes")), Contains("VLA ids") && Contains("not the RL ids"));
  // Fewer episodes, or other tasks, have no mean.
  CHECK(is_null(part(entry(five_tasks(50)), "overall_score")));
  const Json others = entry(some_tasks());
  CHECK(is_null(part(others, "overall_score")));
  CHECK(number(part(part(others, "task_scores"), "SeqOfColors3-Long")) == 25);
}

TEST_CASE("vla-eval's entry is of policies that act in usual environments",
          "[evaluation][results]") {
  const auto refuse = [](const EvaluationSettings& settings, const char* words) {
    const JsonList tasks = {task_of("RememberColor3-VLA-v0", {true, false}),
                            task_of("RememberColor5-VLA-v0", {true, false}, settings)};
    CHECK_THROWS_WITH(result_table(TableFormat::kVlaEval, tasks),
                      Contains("format vla-eval: RememberColor5-VLA-v0") && Contains(words));
    CHECK_NOTHROW(result_table(TableFormat::kMarkdown, tasks));
  };
  EvaluationSettings choices;
  choices.choices = true;
  refuse(choices, "results of choices given, of actions needed");
  EvaluationSettings perturbed;
  perturbed.perturbations = {{PerturbationAxis::kLight, 0.5}};
  refuse(perturbed, "results under perturbations given, without them needed");
  EvaluationSettings changed;
  changed.constants = {{"EMPTY_PHASE_STEPS", 3}};
  refuse(changed, "results of changed constants given, the task's own needed");
  EvaluationSettings other_physics;
  other_physics.physics = Physics::kMujoco;
  refuse(other_physics, "physics mujoco ");
  EvaluationSettings original;
  original.rules = Rules::kOriginal;
  refuse(original, "rules 'original' given, 'reference' needed");
}

}  // namespace
}  // namespace engram
