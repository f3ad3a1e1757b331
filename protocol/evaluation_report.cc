#include "protocol/evaluation_report.h"

#include <algorithm>
#include <cstdio>

#include "protocol/html_report.h"

namespace engram {
namespace {

std::string number(const char* format, double value) {
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

struct Group {
  double sum = 0;
  int tasks = 0;
  double rate() const { return sum / tasks; }
};

// Rates of the tasks that have the same value under `key`.
std::map<std::string, Group> grouped(const std::vector<Json>& tasks, const char* key) {
  std::map<std::string, Group> groups;
  for (const Json& task : tasks) {
    Group& group = groups[task.at(key).get<std::string>()];
    group.sum += task.at("sr").get<double>();
    ++group.tasks;
  }
  return groups;
}

void add_rates(const std::map<std::string, Group>& groups, HtmlReport& report) {
  std::vector<HtmlReport::Bar> bars;
  for (const auto& [name, group] : groups) {
    bars.push_back(
        {name + " (" + std::to_string(group.tasks) + ")", group.rate(), -1, "mean of task rates"});
  }
  report.bars(bars);
}

}  // namespace

std::string evaluation_report(const EvaluationSettings& settings, const std::vector<Json>& tasks,
                              const std::map<std::string, double>& thread_seconds,
                              const std::map<std::string, Bytes>& samples,
                              const ReportContext& context) {
  const Json summary = summary_document(tasks);
  HtmlReport report("Evaluation: " + settings.policy + ", " + std::to_string(tasks.size()) +
                    " tasks");
  double env_steps = 0;
  double seconds = 0;
  int chunk_size = 1;
  std::vector<HtmlReport::Bar> bars;
  std::vector<std::vector<std::string>> rows;
  for (const Json& task : tasks) {
    const auto id = task.at("env_id").get<std::string>();
    const double rate = task.at("sr").get<double>();
    double steps = 0;
    for (const Json& length : task.at("episode_lengths")) steps += length.get<double>();
    const double episodes = static_cast<double>(task.at("episode_lengths").size());
    const auto timed = thread_seconds.find(id);
    const double own_seconds = timed == thread_seconds.end() ? 0 : timed->second;
    env_steps += steps;
    seconds += own_seconds;
    chunk_size = std::max(chunk_size, task.at("action_chunk_size").get<int>());
    const double chance = task.contains("chance") ? task.at("chance").get<double>() : -1;
    bars.push_back({id, rate, chance, task.at("split").get<std::string>()});
    rows.push_back({id, task.at("split").get<std::string>(),
                    task.at("memory_type").get<std::string>(), number("%.3f", rate),
                    chance < 0 ? "" : number("%.3f", chance),
                    number("%.2f", task.at("mean_return").get<double>()),
                    number("%.1f", episodes > 0 ? steps / episodes : 0),
                    own_seconds > 0 ? number("%.2f", own_seconds) : "",
                    own_seconds > 0 ? number("%.0f", steps / own_seconds) : ""});
  }
  const std::string first = std::to_string(settings.start_seed);
  report.table({"", ""},
               {{"split", summary.at("split").get<std::string>()},
                {"mean success rate", number("%.4f", summary.at("sr_split").get<double>())},
                {"policy", settings.policy},
                {"observations", settings.obs_mode},
                {"renderer", settings.renderer},
                {"episodes per task", std::to_string(settings.episodes)},
                {"first seed", first},
                {"action chunk size", std::to_string(chunk_size)},
                {"engram", version()},
                {"compute", context.compute},
                {"GPU", "none"},
                {"environment steps", number("%.0f", env_steps)},
                {"time of all threads, s", number("%.1f", seconds)},
                {"wall time since begun or resumed, s", number("%.1f", context.wall_seconds)}});
  report.heading("Success per split");
  add_rates(grouped(tasks, "split"), report);
  report.heading("Success per memory type");
  add_rates(grouped(tasks, "memory_type"), report);
  report.heading("Success per task");
  report.paragraph(
      "Share of episodes with success in any step; the red line is what guessing gets.");
  report.bars(bars);
  report.heading("Tasks and timing");
  report.table({"task", "split", "memory type", "success_once", "chance", "mean return",
                "mean steps", "thread s", "steps/s of a thread"},
               rows);
  if (!samples.empty()) report.heading("Seed " + first + ", base camera, from start to end");
  for (const auto& [id, png] : samples) report.picture(id, png);
  return report.text();
}

}  // namespace engram
