#include "tasks/common/changes.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/error.h"
#include "core/base/join.h"
#include "core/base/nearest.h"

namespace engram::tasks {
namespace {

// Of a list; anything else counts as a list of itself alone.
std::span<const Constant> elements(const Constant& constant) {
  if (const auto* list = std::get_if<ConstantList>(&constant.value)) return *list;
  return {&constant, 1};
}

// --- values in words ---

std::string from_to(double low, double high) { return shortest(low) + " to " + shortest(high); }

// What a user may give: "a whole number from 2 to 9".
std::string allowed(const TaskConstant& about) {
  using enum TaskConstant::Kind;
  const std::string bounds = from_to(about.low, about.high);
  switch (about.kind) {
    case kInteger:
      return "a whole number from " + bounds;
    case kReal:
      return "a number from " + bounds;
    case kIntegerRange:
      return "least and greatest, whole numbers from " + bounds + ",";
    case kRealRange:
      return "least and greatest, numbers from " + bounds + ",";
    case kReals:
      return std::to_string(elements(about.value).size()) + " numbers from " + bounds;
    case kName:
      return "one of " + join(about.names);
    case kNames:
      return bounds + " different names of " + join(about.names);
  }
  return "";
}

// --- values of the right kind ---

bool is_number(const TaskConstant& about, const Constant& given, bool whole) {
  const std::optional<double> value = as_number(given);
  return value && *value >= about.low && *value <= about.high &&
         (!whole || std::nearbyint(*value) == *value);
}

bool are_numbers(const TaskConstant& about, const Constant& given, bool whole) {
  return std::ranges::all_of(elements(given),
                             [&](const Constant& value) { return is_number(about, value, whole); });
}

// Two numbers, or one that is both.
bool is_range(const TaskConstant& about, const Constant& given, bool whole) {
  const auto list = elements(given);
  return (list.size() == 1 || list.size() == 2) && are_numbers(about, given, whole) &&
         *as_number(list.front()) <= *as_number(list.back());
}

int index_of(const TaskConstant& about, const Constant& given) {
  const auto* text = std::get_if<std::string>(&given.value);
  const auto found = text == nullptr ? about.names.end() : std::ranges::find(about.names, *text);
  return found == about.names.end() ? -1 : static_cast<int>(found - about.names.begin());
}

bool are_names(const TaskConstant& about, const Constant& given) {
  const auto list = elements(given);
  const auto count = static_cast<double>(list.size());
  if (count < about.low || count > about.high) return false;
  for (auto here = list.begin(); here != list.end(); ++here) {
    if (index_of(about, *here) < 0 || std::find(list.begin(), here, *here) != here) return false;
  }
  return true;
}

bool fits(const TaskConstant& about, const Constant& given) {
  using enum TaskConstant::Kind;
  switch (about.kind) {
    case kInteger:
      return is_number(about, given, true);
    case kReal:
      return is_number(about, given, false);
    case kIntegerRange:
      return is_range(about, given, true);
    case kRealRange:
      return is_range(about, given, false);
    case kReals:
      return elements(given).size() == elements(about.value).size() &&
             are_numbers(about, given, false);
    case kName:
      return index_of(about, given) >= 0;
    case kNames:
      return are_names(about, given);
  }
  return false;
}

ConstantList names_of(std::span<const char* const> names, const NameList& chosen) {
  ConstantList list;
  for (int i = 0; i < chosen.size(); ++i) {
    list.emplace_back(names[static_cast<std::size_t>(chosen[i])]);
  }
  return list;
}

}  // namespace

Changes::Changes(const ConstantTable& given) : given_(given) {
  for (auto here = given.begin(); here != given.end(); ++here) {
    const auto same = [here](const auto& entry) { return entry.first == here->first; };
    if (std::find_if(given.begin(), here, same) == here) continue;
    throw Error(Error::kInvalidArgument,
                "constant '" + here->first + "' given twice, once allowed");
  }
}

const Constant* Changes::find(std::string_view name) const {
  const auto found = std::ranges::find(
      given_, name, [](const auto& entry) -> std::string_view { return entry.first; });
  return found == given_.end() ? nullptr : &found->second;
}

const Constant* Changes::add(TaskConstant about) {
  const Constant* given = find(about.name);
  if (given != nullptr && !fits(about, *given)) {
    refuse_constant(about.name, in_words(*given), allowed(about) + " allowed");
  }
  listed_.push_back(std::move(about));
  return given;
}

std::span<const Constant> Changes::add_numbers(const char* name, Kind kind, Constant value,
                                               Bounds bounds, const char* unit, const char* text) {
  const Constant* given = add({.name = name,
                               .kind = kind,
                               .value = std::move(value),
                               .low = bounds.low,
                               .high = bounds.high,
                               .unit = unit,
                               .description = text});
  if (given == nullptr) return {};
  return elements(*given);
}

void Changes::integer(const char* name, int& value, Bounds bounds, const char* unit,
                      const char* text) {
  const auto given = add_numbers(name, Kind::kInteger, value, bounds, unit, text);
  if (given.empty()) return;
  value = static_cast<int>(*as_number(given[0]));
  listed_.back().value = value;
}

void Changes::real(const char* name, double& value, Bounds bounds, const char* unit,
                   const char* text) {
  const auto given = add_numbers(name, Kind::kReal, value, bounds, unit, text);
  if (given.empty()) return;
  value = *as_number(given[0]);
  listed_.back().value = value;
}

void Changes::steps(const char* name, StepRange& value, Bounds bounds, const char* text) {
  integer_range(name, value.low, value.high, bounds, "control steps", text);
}

void Changes::integer_range(const char* name, int& low, int& high, Bounds bounds, const char* unit,
                            const char* text) {
  const auto given =
      add_numbers(name, Kind::kIntegerRange, ConstantList{low, high}, bounds, unit, text);
  if (given.empty()) return;
  low = static_cast<int>(*as_number(given.front()));
  high = static_cast<int>(*as_number(given.back()));
  listed_.back().value = ConstantList{low, high};
}

void Changes::real_range(const char* name, double& low, double& high, Bounds bounds,
                         const char* unit, const char* text) {
  const auto given =
      add_numbers(name, Kind::kRealRange, ConstantList{low, high}, bounds, unit, text);
  if (given.empty()) return;
  low = *as_number(given.front());
  high = *as_number(given.back());
  listed_.back().value = ConstantList{low, high};
}

void Changes::reals(const char* name, std::span<double> values, Bounds bounds, const char* unit,
                    const char* text) {
  const auto given = add_numbers(name, Kind::kReals, ConstantList(values.begin(), values.end()),
                                 bounds, unit, text);
  if (given.empty()) return;
  std::ranges::transform(given, values.begin(),
                         [](const Constant& one) { return *as_number(one); });
  listed_.back().value = ConstantList(values.begin(), values.end());
}

void Changes::name(const char* name, int& index, std::span<const char* const> names,
                   const char* text) {
  const Constant* given = add({.name = name,
                               .kind = Kind::kName,
                               .value = names[static_cast<std::size_t>(index)],
                               .names = {names.begin(), names.end()},
                               .unit = "",
                               .description = text});
  if (given == nullptr) return;
  index = index_of(listed_.back(), *given);
  listed_.back().value = *given;
}

void Changes::names(const char* name, NameList& value, std::span<const char* const> names,
                    int least, const char* text) {
  const Constant* given = add({.name = name,
                               .kind = Kind::kNames,
                               .value = names_of(names, value),
                               .low = static_cast<double>(least),
                               .high = static_cast<double>(names.size()),
                               .names = {names.begin(), names.end()},
                               .unit = "",
                               .description = text});
  if (given == nullptr) return;
  value.clear();
  for (const Constant& one : elements(*given)) value.push_back(index_of(listed_.back(), one));
  listed_.back().value = names_of(names, value);
}

std::string in_millimetres(double metres) {
  return std::to_string(std::lround(1000 * metres)) + " mm";
}

void refuse_constant(const std::string& name, const std::string& given,
                     const std::string& allowed) {
  throw Error(Error::kInvalidArgument, "constant '" + name + "': " + given + " given, " + allowed);
}

void check_time(int horizon, std::initializer_list<Stretch> stretches, int least_to_act) {
  int sum = least_to_act;
  std::string words;
  for (const Stretch& stretch : stretches) {
    sum += stretch.steps;
    words += std::string(stretch.name) + " " + std::to_string(stretch.steps) + " + ";
  }
  if (sum <= horizon) return;
  throw Error(Error::kInvalidArgument,
              "constants leave no time to act: " + words + std::to_string(least_to_act) +
                  " to act = " + std::to_string(sum) +
                  " control steps, more than max_episode_steps " + std::to_string(horizon));
}

std::vector<TaskConstant> Changes::take() {
  for (const auto& [name, value] : given_) {
    const std::string_view wanted = name;
    if (std::ranges::find(listed_, wanted, &TaskConstant::name) != listed_.end()) continue;
    throw Error(Error::kUnknownId, "no constant named '" + name + "' to change; did you mean '" +
                                       nearest(listed_, name, &TaskConstant::name) +
                                       "'? This task has: " + join(listed_, &TaskConstant::name));
  }
  return std::move(listed_);
}

}  // namespace engram::tasks
