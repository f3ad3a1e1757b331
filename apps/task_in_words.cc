#include "apps/task_in_words.h"

#include <fmt/format.h>

#include "apps/output.h"

namespace engram::apps {
namespace {

std::string plain(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return fmt::format("{:.6g}", value.get<double>());
  return value.is_null() ? "-" : value.dump();
}

// A table of objects: one column per key, under a heading.
std::string section(const std::string& title, const Json& rows,
                    const std::vector<Table::Column>& columns) {
  if (rows.empty()) return "";
  Table table(columns);
  for (const Json& row : rows) {
    std::vector<std::string> cells;
    cells.reserve(columns.size());
    for (const Table::Column& column : columns) cells.push_back(plain(row[column.name]));
    table.add(std::move(cells));
  }
  return fmt::format("\n{}\n{}", title, table.text("  "));
}

std::string head(const Json& task) {
  return fmt::format(
      "{}: \"{}\"\n"
      "  family {}, split {}, memory type {}, {}\n"
      "  horizon {} control steps; ends early: {}; actions frozen until the cue is over: {}\n"
      "  {} candidates; a guess succeeds with probability {:.3f}\n",
      plain(task["id"]), plain(task["instruction"]), plain(task["family"]), plain(task["split"]),
      plain(task["memory_type"]), task["canonical"] ? "canonical" : "not canonical",
      plain(task["horizon"]), plain(task["termination"]), task["frozen_cue"] ? "yes" : "no",
      plain(task["candidates"]), task["chance"].get<double>());
}

std::string action_section(const Json& modes) {
  Table table({{"mode"}, {"dim", true}, {"low"}, {"high"}});
  const auto shortened = [](const Json& values) {
    bool same = true;
    for (const Json& value : values) same = same && value == values[0];
    return same ? fmt::format("{} each", plain(values[0])) : values.dump();
  };
  for (const auto& [mode, space] : modes.items()) {
    table.add({mode, space["dim"].dump(), shortened(space["low"]), shortened(space["high"])});
  }
  return "\nActions by control mode\n" + table.text("  ");
}

std::string constant_section(const Json& constants) {
  std::string text = "\nConstants\n";
  for (const auto& [name, value] : constants.items()) {
    text += fmt::format("  {} = {}\n", name, plain(value));
  }
  return constants.empty() ? "" : text;
}

std::string reward_section(const Json& task) {
  std::string text = fmt::format("\nReward\n  dense reward of a success step: {}\n",
                                 plain(task["success_reward"]));
  if (!task["reward_terms"].empty()) {
    text += "  terms (info reward_dict):";
    for (const Json& term : task["reward_terms"]) text += fmt::format(" {}", plain(term));
    text += "\n";
  }
  return text;
}

}  // namespace

std::string describe_in_words(const Json& task) {
  const Table::Column name{"name"};
  const Table::Column width{"width", true};
  const Table::Column unit{"unit"};
  const Table::Column description{"description"};
  const Table::Column offset{"offset", true};
  return head(task) + section("Phases", task["phases"], {name, {"when"}}) +
         section("Drawn per episode, can be pinned", task["draws"],
                 {name, width, {"integer"}, {"low", true}, {"high", true}, unit, description}) +
         section("Options of the task", task["options"],
                 {name,
                  {"default", true},
                  {"integer"},
                  {"low", true},
                  {"high", true},
                  unit,
                  description}) +
         section("Props", task["props"],
                 {name, {"motion"}, {"mass", true}, {"bounding_radius", true}}) +
         action_section(task["action_spaces"]) +
         section(fmt::format("State observation, {} values", plain(task["state_dim"])),
                 task["state_fields"], {name, offset, width, unit, description}) +
         section("Proprio", task["proprio"], {name, offset, width, unit, description}) +
         section("Outputs", task["outputs"], {name, {"dtype"}, width, unit, description}) +
         reward_section(task) + constant_section(task["constants"]);
}

}  // namespace engram::apps
