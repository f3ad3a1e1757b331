#include "core/task/task_option.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/base/join.h"

namespace engram {
namespace {

[[noreturn]] void refuse_name(std::span<const TaskOptionSpec> options, const std::string& name) {
  const std::string names = options.empty() ? "none" : join(options, &TaskOptionSpec::name);
  throw Error(Error::kUnknownId, "no option named '" + name + "'; this task has: " + names);
}

void check_value(const TaskOptionSpec& option, double value) {
  const bool whole = !option.integer || std::nearbyint(value) == value;
  if (whole && value >= option.low && value <= option.high) return;
  throw Error(Error::kInvalidArgument,
              "option '" + option.name + "': " + shortest(value) + " given, " +
                  (option.integer ? "a whole number" : "a number") + " from " +
                  shortest(option.low) + " to " + shortest(option.high) + " allowed");
}

}  // namespace

double TaskOptionSpec::value_under(Rules rules) const {
  return rules == Rules::kOriginal ? original.value_or(value) : value;
}

std::vector<double> option_values(std::span<const TaskOptionSpec> options,
                                  std::span<const TaskOptionValue> choices, Rules rules) {
  std::vector<double> values;
  for (const TaskOptionSpec& option : options) values.push_back(option.value_under(rules));
  std::vector<bool> chosen(options.size(), false);
  for (const TaskOptionValue& choice : choices) {
    const auto found = std::find_if(
        options.begin(), options.end(),
        [&choice](const TaskOptionSpec& option) { return option.name == choice.name; });
    if (found == options.end()) refuse_name(options, choice.name);
    check_value(*found, choice.value);
    const auto index = static_cast<std::size_t>(found - options.begin());
    if (chosen[index]) {
      throw Error(Error::kInvalidArgument,
                  "option '" + choice.name + "' given twice, once allowed");
    }
    chosen[index] = true;
    values[index] = choice.value;
  }
  return values;
}

}  // namespace engram
