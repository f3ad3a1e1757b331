#include "apps/task_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/output.h"

namespace engram::apps {
namespace {

std::string plain(const Json& value) {
  if (const auto* text = std::get_if<std::string>(&value.value)) return *text;
  if (const auto* number = std::get_if<double>(&value.value)) {
    return std::isfinite(*number) ? fmt::format("{:.6g}", *number) : "-";
  }
  return is_null(value) ? "-" : to_line(value);
}

std::string plain(const Json& table, std::string_view key) { return plain(part(table, key)); }

// A table of objects: one column per key, under a heading.
std::string section(const std::string& title, const Json& rows,
                    const std::vector<Table::ColumnHeader>& columns) {
  if (list(rows).empty()) return "";
  Table table(columns);
  for (const Json& row : list(rows)) {
    std::vector<std::string> cells;
    cells.reserve(columns.size());
    for (const Table::ColumnHeader& column : columns) cells.push_back(plain(row, column.name));
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
      plain(task, "id"), plain(task, "instruction"), plain(task, "family"), plain(task, "split"),
      plain(task, "memory_type"), truth(part(task, "canonical")) ? "canonical" : "not canonical",
      plain(task, "horizon"), plain(task, "termination"),
      truth(part(task, "frozen_cue")) ? "yes" : "no", plain(task, "candidates"),
      number(part(task, "chance")));
}

// The definition of an answer, and the scores of policies.
std::string memory_section(const Json& task) {
  std::string text;
  if (const Json& answer = part(task, "answer"); !is_null(answer)) {
    text += fmt::format("\nAnswer\n  {}\n  a guess is right first with probability {:.3f}\n",
                        plain(answer), number(part(task, "answer_chance")));
  }
  if (const Json& choices = part(task, "choices"); !is_null(choices)) {
    const Json& items = part(choices, "choices");
    text += fmt::format("\nChoices (docs/choices.md)\n  {}\n", plain(choices, "question"));
    if (!is_null(items)) text += fmt::format("  {}\n", to_line(items));
  }
  const Json& ceilings = part(task, "ceilings");
  if (is_null(ceilings)) return text;
  Table rows({{"policy"}, {"success_once", true}, {"first_answer_correct", true}});
  for (const auto& [policy, rates] : table(ceilings)) {
    rows.add({policy, plain(rates, "success_once"), plain(rates, "first_answer_correct")});
  }
  return text + "\nMeasured over 200 episodes (docs/memory.md)\n" + rows.text("  ");
}

std::string action_section(const Json& modes) {
  Table rows({{"mode"}, {"dim", true}, {"low"}, {"high"}});
  const auto shortened = [](const Json& bounds) {
    const JsonList& values = list(bounds);
    const bool same = std::all_of(values.begin(), values.end(),
                                  [&](const Json& value) { return value == values[0]; });
    return same ? fmt::format("{} each", plain(values[0])) : to_line(bounds);
  };
  for (const auto& [mode, space] : table(modes)) {
    rows.add(
        {mode, plain(space, "dim"), shortened(part(space, "low")), shortened(part(space, "high"))});
  }
  return "\nActions by control mode\n" + rows.text("  ");
}

std::string constant_section(const Json& constants) {
  std::string text = "\nConstants\n";
  for (const auto& [name, value] : table(constants)) {
    text += fmt::format("  {} = {}\n", name, plain(value));
  }
  return table(constants).empty() ? "" : text;
}

std::string segmentation_section(const Json& names) {
  Table rows({{"value", true}, {"name"}});
  for (std::size_t i = 0; i < list(names).size(); ++i) {
    rows.add({std::to_string(i), plain(list(names)[i])});
  }
  return list(names).empty() ? "" : "\nSegmentation\n" + rows.text("  ");
}

std::string reward_section(const Json& task) {
  std::string text = fmt::format("\nReward\n  dense reward of a success step: {}\n",
                                 plain(task, "success_reward"));
  const JsonList& terms = list(part(task, "reward_terms"));
  if (!terms.empty()) {
    text += "  terms (info reward_dict):";
    for (const Json& term : terms) text += fmt::format(" {}", plain(term));
    text += "\n";
  }
  return text;
}

}  // namespace

std::string task_text(const Json& task) {
  const Table::ColumnHeader name{"name"};
  const Table::ColumnHeader width{"width", true};
  const Table::ColumnHeader unit{"unit"};
  const Table::ColumnHeader description{"description"};
  const Table::ColumnHeader offset{"offset", true};
  return head(task) + memory_section(task) +
         section("Phases", part(task, "phases"), {name, {"when"}}) +
         section("Drawn per episode, can be pinned", part(task, "draws"),
                 {name, width, {"integer"}, {"low", true}, {"high", true}, unit, description}) +
         section(fmt::format("Options of the task, rules {}", plain(task, "rules")),
                 part(task, "options"),
                 {name,
                  {"value", true},
                  {"default", true},
                  {"original", true},
                  {"integer"},
                  {"low", true},
                  {"high", true},
                  unit,
                  description}) +
         section("Constants that can be changed (--set NAME=VALUE)", part(task, "changeable"),
                 {name, {"value"}, {"low", true}, {"high", true}, unit, description}) +
         section("Props", part(task, "props"),
                 {name, {"motion"}, {"mass", true}, {"bounding_radius", true}}) +
         action_section(part(task, "action_spaces")) +
         section(fmt::format("Observation, {} values", plain(task, "state_dim")),
                 part(task, "state_fields"), {name, offset, width, unit, description}) +
         section("Proprio", part(task, "proprio"), {name, offset, width, unit, description}) +
         segmentation_section(part(task, "segmentation_names")) +
         section("Outputs", part(task, "outputs"),
                 {name, {"dtype"}, width, {"privileged"}, unit, description}) +
         reward_section(task) + constant_section(part(task, "constants"));
}

}  // namespace engram::apps
