#include "protocol/evaluation/evaluation_report.h"

#include <algorithm>

#include "protocol/formats/decimal.h"
#include "protocol/formats/html.h"

namespace engram {
namespace {

struct Group {
  double sum = 0;
  int tasks = 0;
  double rate() const { return sum / tasks; }
};

// Rates of the tasks that have the same value under `key`.
std::map<std::string, Group> grouped(const DocumentList& tasks, const char* key) {
  std::map<std::string, Group> groups;
  for (const Document& task : tasks) {
    Group& group = groups[text(part(task, key))];
    group.sum += number(part(task, "sr"));
    ++group.tasks;
  }
  return groups;
}

void add_rates(const std::map<std::string, Group>& groups, HtmlReport& report) {
  std::vector<HtmlReport::RateBar> bars;
  bars.reserve(groups.size());
  for (const auto& [name, group] : groups) {
    bars.push_back(
        {name + " (" + std::to_string(group.tasks) + ")", group.rate(), -1, "mean of task rates"});
  }
  report.bars(bars);
}

}  // namespace

std::string evaluation_report(const EvaluationSettings& settings, const DocumentList& tasks,
                              const std::map<std::string, double>& thread_seconds,
                              const std::map<std::string, Bytes>& samples,
                              const ReportContext& context) {
  const Document summary = summary_document(tasks);
  HtmlReport report("Evaluation: " + settings.policy + ", " + std::to_string(tasks.size()) +
                    " tasks");
  double env_steps = 0;
  double seconds = 0;
  int chunk_size = 1;
  std::vector<HtmlReport::RateBar> bars;
  std::vector<std::vector<std::string>> rows;
  for (const Document& task : tasks) {
    const std::string& id = text(part(task, "env_id"));
    const double rate = number(part(task, "sr"));
    double steps = 0;
    for (const Document& length : list(part(task, "episode_lengths"))) steps += number(length);
    const double episodes = static_cast<double>(list(part(task, "episode_lengths")).size());
    const auto timed = thread_seconds.find(id);
    const double own_seconds = timed == thread_seconds.end() ? 0 : timed->second;
    env_steps += steps;
    seconds += own_seconds;
    chunk_size =
        std::max(chunk_size, static_cast<int>(whole_number(part(task, "action_chunk_size"))));
    const double chance = number(part(task, "chance"));
    const auto share = [&task](const char* key) {
      const Document& value = part(task, key);
      return is_null(value) ? std::string() : decimal(number(value), 3);
    };
    bars.push_back({id, rate, chance, text(part(task, "split"))});
    rows.push_back({id, text(part(task, "split")), text(part(task, "memory_type")),
                    decimal(rate, 3), share("chance"), share("memory_score"),
                    share("first_answer_correct"), decimal(number(part(task, "mean_return")), 2),
                    decimal(episodes > 0 ? steps / episodes : 0, 1),
                    own_seconds > 0 ? decimal(own_seconds, 2) : "",
                    own_seconds > 0 ? decimal(steps / own_seconds, 0) : ""});
  }
  const std::string first = std::to_string(settings.start_seed);
  report.table({"", ""},
               {{"split", text(part(summary, "split"))},
                {"mean success rate", decimal(number(part(summary, "sr_split")), 4)},
                {"policy", settings.policy},
                {"observations", name_of(settings.obs_mode)},
                {"rules", name_of(settings.rules)},
                {"renderer", settings.renderer},
                {"episodes per task", std::to_string(settings.episodes)},
                {"first seed", first},
                {"action chunk size", std::to_string(chunk_size)},
                {"engram", version()},
                {"compute", context.compute},
                {"GPU", "none"},
                {"environment steps", decimal(env_steps, 0)},
                {"time of all threads, s", decimal(seconds, 1)},
                {"wall time since begun or resumed, s", decimal(context.wall_seconds, 1)}});
  report.heading("Success per split");
  add_rates(grouped(tasks, "split"), report);
  report.heading("Success per memory type");
  add_rates(grouped(tasks, "memory_type"), report);
  report.heading("Success per task");
  report.paragraph(
      "Share of episodes with success in any step; the red line is what guessing gets. In the "
      "table "
      "below, score is 0 for the best policy without memory and 1 for the oracle; first answer is "
      "the share of episodes in which the robot's first answer was right.");
  report.bars(bars);
  report.heading("Tasks and timing");
  report.table({"task", "split", "memory type", "success_once", "chance", "score", "first answer",
                "mean return", "mean steps", "thread s", "steps/s of a thread"},
               rows);
  if (!samples.empty()) report.heading("Seed " + first + ", base camera, from start to end");
  for (const auto& [id, png] : samples) report.picture(id, png);
  return report.text();
}

}  // namespace engram
