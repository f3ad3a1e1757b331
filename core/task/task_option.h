// Options of a task: numbers by which users choose between variants of its rules, the same for all
// environments of a batch.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/task/rules.h"

namespace engram {

// An option that a task has. A switch is a whole number of 0 and 1.
struct TaskOptionSpec {
  std::string name;
  double value = 0;  // the default
  bool integer = false;
  double low = 0;  // least and greatest value, both included
  double high = 1;
  std::string unit;
  std::string description;
  std::optional<double> original = std::nullopt;  // what the original's code has, where it differs

  // Its value where none is chosen.
  double value_under(Rules rules) const;
};

// A user's choice.
struct TaskOptionValue {
  std::string name;
  double value = 0;
};

// The values of a task's options, in their order: what the rules say, unless a choice says
// something else. Throws Error, naming what is allowed, unless every choice names an option once
// and is within its range.
std::vector<double> option_values(std::span<const TaskOptionSpec> options,
                                  std::span<const TaskOptionValue> choices, Rules rules = Rules{});

}  // namespace engram
