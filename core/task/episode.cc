#include "core/task/episode.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>

#include "core/base/checksum.h"
#include "core/base/error.h"
#include "core/base/index.h"
#include "core/base/join.h"
#include "core/base/nearest.h"
#include "core/task/task_constant.h"

namespace engram {
namespace {

void check_value(const RandomVariable& variable, double value) {
  const bool whole = !variable.integer || std::nearbyint(value) == value;
  if (whole && value >= variable.low && value <= variable.high) return;
  throw Error(Error::kInvalidArgument,
              "pin '" + variable.name + "': value " + shortest(value) + " given, " +
                  (variable.integer ? "a whole number" : "a number") + " from " +
                  shortest(variable.low) + " to " + shortest(variable.high) + " allowed");
}

[[noreturn]] void refuse_range(const std::vector<RandomVariable>& variables,
                               const std::string& name) {
  std::vector<std::string> names;
  for (const RandomVariable& variable : variables) {
    const bool known = std::ranges::find(names, variable.constant) != names.end();
    if (!variable.constant.empty() && !known) names.push_back(variable.constant);
  }
  throw Error(Error::kUnknownId, "no range '" + name + "' to narrow at reset; " +
                                     (names.empty() ? std::string("this task has none")
                                                    : "did you mean '" + nearest(names, name) +
                                                          "'? This task has: " + join(names)));
}

// Reads [least, greatest], or one number that is both; nothing for anything else.
std::optional<std::pair<double, double>> read_range(const Constant& value) {
  const auto* list = std::get_if<ConstantList>(&value.value);
  const std::span<const Constant> bounds =
      list != nullptr ? std::span<const Constant>(*list) : std::span<const Constant>(&value, 1);
  if (bounds.empty() || bounds.size() > 2) return std::nullopt;
  const std::optional<double> low = as_number(bounds.front());
  const std::optional<double> high = as_number(bounds.back());
  if (!low || !high) return std::nullopt;
  return std::pair{*low, *high};
}

// True for a range within that of the variable.
bool is_within(const RandomVariable& variable, double low, double high) {
  const bool whole = std::trunc(low) == low && std::trunc(high) == high;
  return variable.low <= low && low <= high && high <= variable.high &&
         (whole || !variable.integer);
}

void check_distinct(const Pin& pin) {
  for (std::size_t i = 1; i < pin.values.size(); ++i) {
    const auto here = pin.values.begin() + static_cast<std::ptrdiff_t>(i);
    if (std::find(pin.values.begin(), here, *here) == here) continue;
    throw Error(Error::kInvalidArgument, "pin '" + pin.name + "': value " + shortest(*here) +
                                             " given twice, different values allowed");
  }
}

}  // namespace

// Stafford's thirteenth mixer of 64 bits: ids that differ in one letter end up far apart.
std::uint64_t stream_salt(std::string_view id) {
  std::uint64_t bits = checksum(id);
  bits = (bits ^ bits >> 30) * 0xbf58476d1ce4e5b9u;
  bits = (bits ^ bits >> 27) * 0x94d049bb133111ebu;
  return bits ^ bits >> 31;
}

PinTable::PinTable(ColumnStore& store, std::vector<RandomVariable> variables)
    : variables_(std::move(variables)) {
  if (variables_.size() > 64) {
    throw Error(Error::kInvalidArgument,
                std::to_string(variables_.size()) +
                    " draws of robot, task and perturbations given, 64 allowed");
  }
  int width = 0;
  for (const RandomVariable& variable : variables_) {
    offsets_.push_back(width);
    width += variable.width;
  }
  pinned_ = store.add<std::uint64_t>("pinned");
  values_ = store.add<double>("pin_values", width);
  narrowed_ = store.add<std::uint64_t>("narrowed");
  ranges_ = store.add<double>("ranges", 2 * static_cast<int>(variables_.size()));
}

int PinTable::find(const std::string& name) const {
  const auto found =
      std::find_if(variables_.begin(), variables_.end(),
                   [&name](const RandomVariable& variable) { return variable.name == name; });
  return found == variables_.end() ? -1 : static_cast<int>(found - variables_.begin());
}

void PinTable::check(const std::vector<Pin>& pins) const {
  std::uint64_t seen = 0;
  for (const Pin& pin : pins) {
    const int index = find(pin.name);
    if (index < 0) {
      throw Error(Error::kUnknownId, "no draw named '" + pin.name + "' to pin; this task has: " +
                                         join(variables_, &RandomVariable::name));
    }
    if ((seen >> index & 1) != 0) {
      throw Error(Error::kInvalidArgument, "pin '" + pin.name + "' given twice, once allowed");
    }
    seen |= std::uint64_t{1} << index;
    const RandomVariable& variable = variables_[at(index)];
    if (pin.values.size() != at(variable.width)) {
      throw Error(Error::kInvalidArgument,
                  "pin '" + pin.name + "': " + std::to_string(pin.values.size()) +
                      " values given, " + std::to_string(variable.width) + " needed");
    }
    for (const double value : pin.values) check_value(variable, value);
    if (variable.distinct) check_distinct(pin);
  }
}

void PinTable::check_saved(std::span<const std::byte> row) const {
  std::uint64_t pinned = 0;
  std::memcpy(&pinned, row.data(), sizeof pinned);
  if (variables_.size() < 64 && pinned >> variables_.size() != 0) {
    throw Error(Error::kInvalidArgument, "snapshot refused: it pins a draw that there is not");
  }
  std::vector<Pin> pins;
  for (std::size_t variable = 0; variable < variables_.size(); ++variable) {
    if ((pinned >> variable & 1) == 0) continue;
    std::vector<double> values(at(variables_[variable].width));
    std::memcpy(values.data(), row.data() + sizeof pinned + at(offsets_[variable]) * sizeof(double),
                values.size() * sizeof(double));
    pins.push_back({variables_[variable].name, std::move(values)});
  }
  check(pins);
  check_saved_ranges(row.subspan(sizeof pinned + at(values_.width()) * sizeof(double)));
}

void PinTable::check_saved_ranges(std::span<const std::byte> row) const {
  std::uint64_t narrowed = 0;
  std::memcpy(&narrowed, row.data(), sizeof narrowed);
  std::vector<double> ranges(2 * variables_.size());
  std::memcpy(ranges.data(), row.data() + sizeof narrowed, ranges.size() * sizeof(double));
  for (std::size_t i = 0; i < 64; ++i) {
    if ((narrowed >> i & 1) == 0) continue;
    if (i < variables_.size() && !variables_[i].constant.empty()) {
      if (is_within(variables_[i], ranges[2 * i], ranges[2 * i + 1])) continue;
    }
    throw Error(Error::kInvalidArgument, "snapshot refused: it narrows a range that there is not");
  }
}

std::vector<NarrowedRange> PinTable::narrowed_ranges(const ConstantTable& ranges) const {
  std::vector<NarrowedRange> result;
  for (const auto& range : ranges) {
    const std::string& name = range.first;
    const auto of_this = [&name](const RandomVariable& variable) {
      return variable.constant == name;
    };
    auto variable = std::ranges::find_if(variables_, of_this);
    if (variable == variables_.end() || name.empty()) refuse_range(variables_, name);
    const std::optional<std::pair<double, double>> bounds = read_range(range.second);
    if (!bounds || !is_within(*variable, bounds->first, bounds->second)) {
      throw Error(Error::kInvalidArgument,
                  "constant '" + name + "' at reset: " + in_words(range.second) + " given, least " +
                      "and greatest" + (variable->integer ? ", whole numbers" : "") + " from " +
                      shortest(variable->low) + " to " + shortest(variable->high) + ", allowed");
    }
    for (; variable != variables_.end();
         variable = std::find_if(variable + 1, variables_.end(), of_this)) {
      result.push_back(
          {static_cast<int>(variable - variables_.begin()), bounds->first, bounds->second});
    }
  }
  return result;
}

void PinTable::narrow(int env, std::span<const NarrowedRange> ranges) const {
  narrowed_[env] = 0;
  for (const NarrowedRange& range : ranges) {
    narrowed_[env] |= std::uint64_t{1} << range.variable;
    ranges_.row(env)[2 * range.variable] = range.low;
    ranges_.row(env)[2 * range.variable + 1] = range.high;
  }
}

const double* PinTable::range(int env, int variable) const {
  if ((narrowed_[env] >> variable & 1) == 0) return nullptr;
  return ranges_.row(env) + 2 * static_cast<std::ptrdiff_t>(variable);
}

void PinTable::set(int env, const std::vector<Pin>& pins) const {
  pinned_[env] = 0;
  for (const Pin& pin : pins) {
    const int index = find(pin.name);
    pinned_[env] |= std::uint64_t{1} << index;
    std::copy(pin.values.begin(), pin.values.end(), values_.row(env) + offsets_[at(index)]);
  }
}

const double* PinTable::values(int env, int variable) const {
  if ((pinned_[env] >> variable & 1) == 0) return nullptr;
  return values_.row(env) + offsets_[at(variable)];
}

int Episode::integer(int variable, int low, int high) const {
  if (const double* value = pinned(variable)) return static_cast<int>(*value);
  narrow(variable, low, high);
  return stream(variable).integer(low, high);
}

double Episode::real(int variable, double low, double high) const {
  if (const double* value = pinned(variable)) return *value;
  narrow(variable, low, high);
  return stream(variable).uniform(low, high);
}

}  // namespace engram
