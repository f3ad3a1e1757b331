#include "apps/eval_sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "apps/output.h"
#include "protocol/eval/results/success_rates.h"

namespace engram::apps {
namespace {

constexpr const char* kReplan = "--replan";
constexpr const char* kHistory = "--history";

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t end = 0; end != std::string::npos; begin = end + 1) {
    end = text.find(',', begin);
    parts.push_back(text.substr(begin, end - begin));
  }
  return parts;
}

std::string* value_of(PolicyServer& server, const char* option) {
  const auto found =
      std::ranges::find(server.options, option, [](auto& given) { return given.first; });
  return found == server.options.end() ? nullptr : &found->second;
}

void set(PolicyServer& server, const char* option, const std::string& value) {
  if (std::string* given = value_of(server, option)) *given = value;
}

}  // namespace

std::vector<std::string> histories_in(const std::string& text) {
  std::vector<std::string> histories;
  bool open = false;  // the last one needs its stride
  for (const std::string& part : split(text)) {
    const bool is_number = !part.empty() && std::isdigit(static_cast<unsigned char>(part[0])) != 0;
    if (open) {
      histories.back() += "," + part;
    } else {
      histories.push_back(part);
    }
    open = is_number && !open;
  }
  return histories;
}

std::vector<SweepPoint> sweep_of(const EvalOptions& options) {
  PolicyServer given = options.policy.server;
  const std::string* replan = value_of(given, kReplan);
  const std::string* history = value_of(given, kHistory);
  const std::vector<std::string> replans = replan ? split(*replan) : std::vector<std::string>{""};
  const std::vector<std::string> histories =
      history ? histories_in(*history) : std::vector<std::string>{""};
  if (replans.size() * histories.size() == 1) return {{replans[0], histories[0], options}};
  if (!options.resume.empty()) {
    throw Error(Error::kInvalidArgument,
                "--resume with lists of --replan or --history given; one value of each allowed, "
                "that of the run");
  }
  std::vector<SweepPoint> points;
  for (const std::string& one_replan : replans) {
    for (const std::string& one_history : histories) {
      SweepPoint point{one_replan, one_history, options};
      set(point.options.policy.server, kReplan, one_replan);
      set(point.options.policy.server, kHistory, one_history);
      std::string name;
      if (replan) name = "replan-" + one_replan;
      if (history) name += (name.empty() ? "history-" : "_history-") + one_history;
      if (!options.out.empty()) point.options.out = std::filesystem::path(options.out) / name;
      points.push_back(std::move(point));
    }
  }
  return points;
}

Json point_document(const SweepPoint& point, const Json& evaluation) {
  const auto value = [](const std::string& text) { return text.empty() ? Json() : Json(text); };
  return JsonTable{{"replan", value(point.replan)},
                   {"history", value(point.history)},
                   {"summary", part(evaluation, "summary")},
                   {"tasks", part(evaluation, "tasks")}};
}

std::string sweep_text(const JsonList& points) {
  Table rows({{"replan"},
              {"history"},
              {"tasks", true},
              {"episodes", true},
              {"success_once", true},
              {"95 % interval", true}});
  for (const Json& point : points) {
    const auto value = [&point](const char* key, const char* usual) {
      return is_null(part(point, key)) ? usual : text(part(point, key));
    };
    const JsonList& tasks = list(part(point, "tasks"));
    std::uint64_t episodes = 0;
    for (const Json& task : tasks) episodes += whole_number(part(task, "n_episodes"));
    const SuccessRate rate = mean_success_rate(tasks);
    rows.add({value("replan", "all"), value("history", "last"), std::to_string(tasks.size()),
              std::to_string(episodes), fmt::format("{:.3f}", rate.rate), to_text(rate.interval)});
  }
  return rows.text();
}

}  // namespace engram::apps
