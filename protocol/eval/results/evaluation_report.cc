#include "protocol/eval/results/evaluation_report.h"

#include <algorithm>

#include "core/base/join.h"
#include "protocol/eval/results/success_rates.h"
#include "protocol/io/decimal.h"
#include "protocol/io/html.h"
#include "protocol/make/physics_keys.h"

namespace engram {
namespace {

void add_rates(const std::map<std::string, SuccessRate>& groups, HtmlReport& report) {
  std::vector<HtmlReport::RateBar> bars;
  bars.reserve(groups.size());
  for (const auto& [name, group] : groups) {
    bars.push_back({name + " (" + std::to_string(group.tasks) + ")", group.rate, -1,
                    "mean of task rates", group.interval.low, group.interval.high});
  }
  report.bars(bars);
}

struct TaskTotals {
  double steps = 0;
  double episodes = 0;
  double seconds = 0;  // of all threads; 0: unknown
};

TaskTotals totals_of(const Json& task, const std::map<std::string, double>& thread_seconds) {
  TaskTotals totals;
  const JsonList& lengths = list(part(task, "episode_lengths"));
  for (const Json& length : lengths) totals.steps += number(length);
  totals.episodes = static_cast<double>(lengths.size());
  const auto timed = thread_seconds.find(text(part(task, "env_id")));
  if (timed != thread_seconds.end()) totals.seconds = timed->second;
  return totals;
}

std::vector<std::string> task_row(const Json& task, const TaskTotals& totals) {
  const auto share = [&task](const char* key) {
    const Json& value = part(task, key);
    return is_null(value) ? std::string() : decimal(number(value), 3);
  };
  const bool timed = totals.seconds > 0;
  return {text(part(task, "env_id")),
          text(part(task, "split")),
          text(part(task, "memory_type")),
          share("sr"),
          to_text(success_rate(task).interval),
          share("chance"),
          share("memory_score"),
          share("first_answer_correct"),
          decimal(number(part(task, "mean_return")), 2),
          decimal(totals.episodes > 0 ? totals.steps / totals.episodes : 0, 1),
          timed ? decimal(totals.seconds, 2) : "",
          timed ? decimal(totals.steps / totals.seconds, 0) : ""};
}

int largest_chunk(const JsonList& tasks) {
  int largest = 1;
  for (const Json& task : tasks) {
    largest = std::max(largest, static_cast<int>(whole_number(part(task, "action_chunk_size"))));
  }
  return largest;
}

std::string seed_text(const EvaluationSettings& settings) {
  if (settings.tells_seeds()) return std::to_string(settings.start_seed);
  return "sealed, SHA-256 of the secret " + settings.commitment->hash();
}

std::string policy_text(const EvaluationSettings& settings) {
  return settings.policy + (settings.choices ? " (names answers; a scripted hand acts)" : "");
}

void add_settings(const EvaluationSettings& settings, const JsonList& tasks,
                  const TaskTotals& totals, const ReportContext& context, HtmlReport& report) {
  const Json summary = summary_document(tasks);
  std::vector<std::string> splits;
  for (const auto& [name, rate] : success_rates_by("split", tasks)) splits.push_back(name);
  report.table({"", ""},
               {{"splits", join(splits)},
                {"mean success rate", decimal(number(part(summary, "sr_split")), 4)},
                {"its 95 % interval", to_text(mean_success_rate(tasks).interval)},
                {"policy", policy_text(settings)},
                {"observations", name_of(settings.obs_mode)},
                {"rules", name_of(settings.rules)},
                {kPhysicsKey, physics_text(settings.document())},
                {"renderer", settings.renderer},
                {"episodes per task", std::to_string(settings.episodes)},
                {"first seed", seed_text(settings)},
                // begin generated: rows (tools/surface, from api/surface.toml)
                {"rounds of the same episodes", std::to_string(settings.repeat)},
                {"policy seed", std::to_string(settings.policy_seed)},
                {"latency, control steps", std::to_string(settings.latency)},
                // end generated
                {"action chunk size", std::to_string(largest_chunk(tasks))},
                {"engram", version()},
                {"compute", context.compute},
                {"GPU", "none"},
                {"environment steps", decimal(totals.steps, 0)},
                {"time of all threads, s", decimal(totals.seconds, 1)},
                {"wall time since begun or resumed, s", decimal(context.wall_seconds, 1)}});
}

}  // namespace

std::string evaluation_report(const EvaluationSettings& settings, const JsonList& tasks,
                              const std::map<std::string, double>& thread_seconds,
                              const std::map<std::string, Bytes>& samples,
                              const ReportContext& context) {
  TaskTotals all;
  std::vector<HtmlReport::RateBar> bars;
  std::vector<std::vector<std::string>> rows;
  for (const Json& task : tasks) {
    const TaskTotals totals = totals_of(task, thread_seconds);
    all.steps += totals.steps;
    all.seconds += totals.seconds;
    const Interval interval = success_rate(task).interval;
    bars.push_back({text(part(task, "env_id")), number(part(task, "sr")),
                    number(part(task, "chance")), text(part(task, "split")), interval.low,
                    interval.high});
    rows.push_back(task_row(task, totals));
  }
  HtmlReport report("Evaluation: " + settings.policy + ", " + counted(tasks.size(), "task"));
  add_settings(settings, tasks, all, context, report);
  report.heading("Success per split");
  add_rates(success_rates_by("split", tasks), report);
  report.heading("Success per memory type");
  add_rates(success_rates_by("memory_type", tasks), report);
  report.heading("Success per task");
  report.paragraph(
      "Share of episodes with success in any step; the thin line is its 95 % interval (Wilson), "
      "the "
      "red line is what guessing gets. In the table below, score is 0 for the best policy without "
      "memory and 1 for the oracle; first answer is "
      "the share of episodes in which the robot's first answer was right.");
  report.bars(bars);
  report.heading("Tasks and timing");
  report.table({"task", "split", "memory type", "success_once", "95 % interval", "chance", "score",
                "first answer", "mean return", "mean steps", "thread s", "steps/s of a thread"},
               rows);
  if (!samples.empty()) {
    report.heading("Seed " + seed_text(settings) + ", base camera, from start to end");
  }
  for (const auto& [id, png] : samples) report.image(id, png);
  return report.text();
}

}  // namespace engram
