#include "protocol/eval/results/result_tables.h"

#include <algorithm>
#include <cctype>
#include <ctime>

#include "core/task/rules.h"
#include "protocol/eval/results/success_rates.h"
#include "protocol/eval/run/mean.h"
#include "protocol/io/decimal.h"
#include "protocol/make/physics_keys.h"

namespace engram {
namespace {

using Cells = std::vector<std::string>;

// --- tables for people ---

const Cells kHeader = {"task", "split", "success", "95 % interval", "chance", "score", "episodes"};
constexpr std::size_t kTextColumns = 2;

std::string share(const Json& task, const char* key) {
  const Json& value = part(task, key);
  return is_null(value) ? "" : decimal(number(value), 3);
}

Cells mean_row(const std::string& what, const std::string& split, const SuccessRate& mean) {
  return {what, split, decimal(mean.rate, 3),        to_text(mean.interval),
          "",   "",    std::to_string(mean.episodes)};
}

std::vector<Cells> task_rows(const JsonList& tasks) {
  std::vector<Cells> rows;
  for (const Json& task : tasks) {
    const SuccessRate rate = success_rate(task);
    rows.push_back({text(part(task, "env_id")), text(part(task, "split")), decimal(rate.rate, 3),
                    to_text(rate.interval), share(task, "chance"), share(task, "memory_score"),
                    std::to_string(rate.episodes)});
  }
  return rows;
}

// Rows of the splits, and of all tasks where there are several splits.
std::vector<Cells> mean_rows(const JsonList& tasks) {
  std::vector<Cells> rows;
  const auto splits = success_rates_by("split", tasks);
  for (const auto& [split, mean] : splits) {
    rows.push_back(mean_row("mean of " + std::to_string(mean.tasks), split, mean));
  }
  if (splits.size() > 1) {
    const SuccessRate mean = mean_success_rate(tasks);
    rows.push_back(mean_row("mean of " + std::to_string(mean.tasks), "all", mean));
  }
  return rows;
}

// A character that a format would read as its own has `before` in front of it.
std::string escaped(std::string_view text, std::string_view special, char before) {
  std::string out;
  for (const char c : text) {
    if (special.find(c) != std::string_view::npos) out += before;
    out += c;
  }
  return out;
}

std::string markdown(const JsonList& tasks) {
  const auto line = [](const Cells& cells) {
    std::string text = "|";
    for (const std::string& cell : cells) text += " " + escaped(cell, "|", '\\') + " |";
    return text + "\n";
  };
  std::string text = line(kHeader);
  Cells rule(kHeader.size(), "---:");
  std::fill_n(rule.begin(), kTextColumns, "---");
  text += line(rule);
  for (const Cells& row : task_rows(tasks)) text += line(row);
  for (const Cells& row : mean_rows(tasks)) text += line(row);
  return text;
}

// For the package booktabs.
std::string latex(const JsonList& tasks) {
  const auto line = [](const Cells& cells) {
    std::string text;
    for (const std::string& cell : cells) {
      text += (text.empty() ? "" : " & ") + escaped(cell, "&%$#_{}", '\\');
    }
    return text + " \\\\\n";
  };
  std::string text = "\\begin{tabular}{" + std::string(kTextColumns, 'l') +
                     std::string(kHeader.size() - kTextColumns, 'r') + "}\n\\toprule\n";
  text += line(kHeader) + "\\midrule\n";
  for (const Cells& row : task_rows(tasks)) text += line(row);
  text += "\\midrule\n";
  for (const Cells& row : mean_rows(tasks)) text += line(row);
  return text + "\\bottomrule\n\\end{tabular}\n";
}

// --- comma-separated values ---

std::string value_text(const Json& value) {
  return is_null(value) ? std::string() : to_line(value);
}

// An item of a list, or nothing where the task has no such list.
std::string item_text(const Json* items, std::size_t i) {
  if (items == nullptr || is_null(*items)) return "";
  const Json& item = list(*items).at(i);
  const auto* words = std::get_if<std::string>(&item.value);
  return words == nullptr ? value_text(item) : *words;
}

std::uint64_t policy_seed_of(const Json& task) {
  const Json* seed = find(task, "policy_seed");
  return seed == nullptr ? 0 : whole_number(*seed);
}

void append_episodes(const Json& task, std::string& text) {
  const std::size_t count = list(part(task, "successes")).size();
  const std::size_t round = count / static_cast<std::size_t>(repeats_of(task));
  const Json* digests = find(task, "digests");
  const auto digest = [digests](const char* key) {
    return digests == nullptr || is_null(*digests) ? nullptr : find(*digests, key);
  };
  for (std::size_t i = 0; i < count; ++i) {
    for (const char* key : {"env_id", "split", "memory_type"})
      text += engram::text(part(task, key)) + ",";
    text += std::to_string(i) + "," + item_text(find(task, "episode_seeds"), i) + "," +
            std::to_string(policy_seed_of(task) + i / std::max<std::size_t>(round, 1));
    for (const char* key :
         {"successes", "returns", "episode_lengths", "first_answers", "first_answers_correct"}) {
      text += "," + item_text(find(task, key), i);
    }
    for (const char* key : {"observations", "answers"}) text += "," + item_text(digest(key), i);
    text += "\n";
  }
}

// --- vla-evaluation-harness ---

constexpr std::array kVlaEvalTasks = {"ShellGameTouch", "InterceptMedium", "RememberColor3",
                                      "RememberColor5", "RememberColor9"};
constexpr int kVlaEvalEpisodes = 100;  // of its protocol, per task

// "RememberColor3" of "RememberColor3-VLA-v0".
std::string short_name(const std::string& id) { return id.substr(0, id.find("-VLA-")); }

std::string model_key(const std::string& name) {
  std::string key;
  for (const char c : name) {
    const auto letter = static_cast<unsigned char>(c);
    key += std::isalnum(letter) != 0 ? static_cast<char>(std::tolower(letter)) : '_';
  }
  return key;
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  char text[16];
  std::strftime(text, sizeof text, "%Y-%m-%d", &utc);
  return text;
}

double in_percent(double rate) { return std::round(1000 * rate) / 10; }

// Its leaderboard is of policies that act, in the benchmark's own environments.
void require_usual_environments(const JsonList& tasks) {
  const auto refuse = [](const Json& task, const std::string& given, const char* needed) {
    throw Error(Error::kInvalidArgument, "format vla-eval: " + text(part(task, "env_id")) + ": " +
                                             given + " given, " + needed + " needed");
  };
  const auto has = [](const Json& task, const char* key) {
    const Json* value = find(task, key);
    return value != nullptr && !is_null(*value);
  };
  for (const Json& task : tasks) {
    if (has(task, "choices")) refuse(task, "results of choices", "of actions");
    if (has(task, "perturbations")) refuse(task, "results under perturbations", "without them");
    if (has(task, "variant")) refuse(task, "results of changed constants", "the task's own");
    const std::string physics = physics_text(task);
    if (physics != name_of(Physics::kEngram)) refuse(task, "physics " + physics, "engram");
    const std::string& rules = text(part(task, "rules"));
    if (rules != name_of(Rules::kReference)) refuse(task, "rules '" + rules + "'", "'reference'");
  }
}

// The five tasks of its protocol if all of them are there, otherwise every task, without a mean.
std::string vla_eval(const JsonList& tasks) {
  require_usual_environments(tasks);
  JsonTable all;
  JsonTable five;
  bool enough = true;
  double sum = 0;
  for (const Json& task : tasks) {
    const std::string name = short_name(text(part(task, "env_id")));
    const SuccessRate rate = success_rate(task);
    all.emplace_back(name, in_percent(rate.rate));
    if (std::ranges::find(kVlaEvalTasks, name) == kVlaEvalTasks.end()) continue;
    five.emplace_back(name, in_percent(rate.rate));
    enough = enough && rate.episodes >= kVlaEvalEpisodes;
    sum += rate.rate;
  }
  const bool standard = five.size() == kVlaEvalTasks.size();
  const Json& first = tasks.front();
  const std::string& name = text(part(part(first, "model"), "name"));
  const std::string notes = "VLA ids of MIKASA-Robo-VLA (not the RL ids), re-created by engram " +
                            text(part(first, "version")) + "; seeds from " +
                            to_line(part(first, "start_seed")) + ", " +
                            to_line(part(first, "n_episodes")) + " episodes a task; observations " +
                            text(part(first, "obs_mode")) + ".";
  return to_text(JsonTable{
      {"model", model_key(name)},
      {"display_name", name},
      {"name_in_paper", nullptr},
      {"benchmark", "mikasa"},
      {"overall_score",
       standard && enough ? Json(in_percent(sum / static_cast<double>(five.size()))) : Json()},
      {"task_scores", standard ? std::move(five) : std::move(all)},
      {"reported_paper", nullptr},
      {"reported_table", nullptr},
      {"curated_by", "human"},
      {"notes", notes},
      {"date_added", today()},
      {"params", nullptr},
      {"model_paper", nullptr},
      {"weight_type", "finetuned"}});
}

}  // namespace

std::string summary_csv(const JsonList& tasks) {
  std::string text =
      "env_id,split,memory_type,n_episodes,sr,chance,memory_score,first_answer_correct,"
      "mean_return,mean_length,sr_low,sr_high\n";
  for (const Json& task : tasks) {
    for (const char* key : {"env_id", "split", "memory_type"})
      text += engram::text(part(task, key)) + ",";
    for (const char* key :
         {"n_episodes", "sr", "chance", "memory_score", "first_answer_correct", "mean_return"}) {
      text += value_text(part(task, key)) + ",";
    }
    std::vector<double> lengths;
    for (const Json& length : list(part(task, "episode_lengths"))) {
      lengths.push_back(number(length));
    }
    const Interval interval = success_rate(task).interval;
    text +=
        to_line(mean(lengths)) + "," + to_line(interval.low) + "," + to_line(interval.high) + "\n";
  }
  return text;
}

std::string episodes_csv(const JsonList& tasks) {
  std::string text =
      "env_id,split,memory_type,episode,seed,policy_seed,success,return,length,first_answer,"
      "first_answer_correct,observations_digest,answers_digest\n";
  for (const Json& task : tasks) append_episodes(task, text);
  return text;
}

std::string result_table(TableFormat format, const JsonList& tasks) {
  if (tasks.empty()) throw Error(Error::kInvalidArgument, "results without a task given");
  switch (format) {
    case TableFormat::kMarkdown:
      return markdown(tasks);
    case TableFormat::kLatex:
      return latex(tasks);
    case TableFormat::kCsv:
      return summary_csv(tasks);
    case TableFormat::kEpisodes:
      return episodes_csv(tasks);
    case TableFormat::kVlaEval:
      return vla_eval(tasks);
  }
  return {};
}

}  // namespace engram
