#include "tasks/common/constant_binder.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/error.h"
#include "core/base/join.h"
#include "core/base/nearest.h"
#include "tasks/common/constant_forms.h"

namespace engram::tasks {
namespace {

// Elements of a list; anything else counts as a list of itself alone.
std::span<const Constant> elements(const Constant& constant) {
  if (const auto* list = std::get_if<ConstantList>(&constant.value)) return *list;
  return {&constant, 1};
}

// --- values in words ---

std::string from_to(double low, double high) { return shortest(low) + " to " + shortest(high); }

// Values that a user may choose: "a whole number from 2 to 9".
std::string allowed(const TaskConstant& about) {
  using enum TaskConstant::Kind;
  const std::string bounds = from_to(about.low, about.high);
  switch (about.kind) {
    case kFixed:
      return "nothing";
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
    case kColors:
      return bounds + " different colours, of " + join(about.names) +
             " or [red, green, blue] from 0 to 1,";
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

// As many as there may be, no two alike.
template <class Fits>
bool are_different(const TaskConstant& about, const Constant& given, const Fits& fits) {
  const auto list = elements(given);
  const auto count = static_cast<double>(list.size());
  if (count < about.low || count > about.high) return false;
  for (auto here = list.begin(); here != list.end(); ++here) {
    const auto same = [here](const Constant& other) { return is_same_value(*here, other); };
    if (!fits(*here) || std::find_if(list.begin(), here, same) != here) return false;
  }
  return true;
}

bool fits(const TaskConstant& about, const Constant& given) {
  using enum TaskConstant::Kind;
  switch (about.kind) {
    case kFixed:
      return false;
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
      return are_different(about, given,
                           [&](const Constant& one) { return index_of(about, one) >= 0; });
    case kColors:
      return are_different(about, given,
                           [](const Constant& one) { return as_color(one).has_value(); });
  }
  return false;
}

ConstantList names_of(std::span<const char* const> names, const NameList& chosen) {
  ConstantList list;
  for (int i = 0; i < chosen.size(); ++i) list.emplace_back(names[at(chosen[i])]);
  return list;
}

std::vector<std::string> color_names() {
  std::vector<std::string> names;
  for (const NamedColor& color : COLOR_MAPPING) names.emplace_back(color.plain_name);
  return names;
}

ConstantList kept_colors(const ColorList& colors) {
  ConstantList list;
  for (int i = 0; i < colors.size(); ++i) list.push_back(kept_color(colors[i]));
  return list;
}

ConstantTable palette_table(const ColorList& colors) {
  ConstantTable table;
  for (int i = 0; i < colors.size(); ++i) {
    table.emplace_back(std::to_string(i), ConstantList(colors[i].begin(), colors[i].end()));
  }
  return table;
}

}  // namespace

ConstantBinder::ConstantBinder(const ConstantTable& chosen) : chosen_(chosen) {
  for (auto here = chosen.begin(); here != chosen.end(); ++here) {
    const auto same = [here](const auto& entry) { return entry.first == here->first; };
    if (std::find_if(chosen.begin(), here, same) == here) continue;
    throw Error(Error::kInvalidArgument,
                "constant '" + here->first + "' given twice, once allowed");
  }
}

const Constant* ConstantBinder::find(std::string_view name) const {
  const auto found = std::ranges::find(
      chosen_, name, [](const auto& entry) -> std::string_view { return entry.first; });
  return found == chosen_.end() ? nullptr : &found->second;
}

const Constant* ConstantBinder::add(TaskConstant about) {
  if (fixed_) about.kind = Kind::kFixed;
  const Constant* chosen = about.changeable() ? find(about.name) : nullptr;
  given_.reset();
  if (chosen != nullptr) {
    given_ = kept_form(about, *chosen);
    if (!fits(about, *given_)) {
      refuse_constant(about.name, in_words(*chosen), allowed(about) + " allowed");
    }
  }
  about.chosen = chosen != nullptr;
  declared_.push_back(std::move(about));
  return given_ ? &*given_ : nullptr;
}

std::span<const Constant> ConstantBinder::add_numbers(const char* name, Kind kind, Constant value,
                                                      Bounds bounds, const char* unit,
                                                      const char* text) {
  const Constant* chosen = add({.name = name,
                                .kind = kind,
                                .value = std::move(value),
                                .low = bounds.low,
                                .high = bounds.high,
                                .unit = unit,
                                .description = text});
  if (chosen == nullptr) return {};
  return elements(*chosen);
}

TaskConstant& ConstantBinder::set(Constant value) {  // NOLINT(performance-unnecessary-value-param)
  TaskConstant& last = declared_.back();
  last.changed = last.chosen && !(value == last.value);
  last.value = value;
  return last;
}

// --- one constant ---

TaskConstant& ConstantBinder::integer(const char* name, int& value, Bounds bounds, const char* unit,
                                      const char* text) {
  const auto chosen = add_numbers(name, Kind::kInteger, value, bounds, unit, text);
  if (!chosen.empty()) value = static_cast<int>(*as_number(chosen[0]));
  return set(value);
}

TaskConstant& ConstantBinder::real(const char* name, double& value, Bounds bounds, const char* unit,
                                   const char* text) {
  const auto chosen = add_numbers(name, Kind::kReal, value, bounds, unit, text);
  if (!chosen.empty()) value = *as_number(chosen[0]);
  return set(value);
}

TaskConstant& ConstantBinder::reals(const char* name, std::span<double> values, Bounds bounds,
                                    const char* unit, const char* text) {
  const auto chosen = add_numbers(name, Kind::kReals, ConstantList(values.begin(), values.end()),
                                  bounds, unit, text);
  std::ranges::transform(chosen, values.begin(),
                         [](const Constant& one) { return *as_number(one); });
  return set(ConstantList(values.begin(), values.end()));
}

TaskConstant& ConstantBinder::name(const char* name, int& index, std::span<const char* const> names,
                                   const char* text) {
  const Constant* chosen = add({.name = name,
                                .kind = Kind::kName,
                                .value = names[at(index)],
                                .names = {names.begin(), names.end()},
                                .description = text});
  if (chosen != nullptr) index = index_of(declared_.back(), *chosen);
  return set(names[at(index)]);
}

TaskConstant& ConstantBinder::names(const char* name, NameList& value,
                                    std::span<const char* const> names, int least, const char* text,
                                    const PublishedForm& published) {
  const Constant* chosen = add({.name = name,
                                .kind = Kind::kNames,
                                .value = names_of(names, value),
                                .low = static_cast<double>(least),
                                .high = static_cast<double>(names.size()),
                                .names = {names.begin(), names.end()},
                                .description = text});
  if (chosen != nullptr) {
    value.clear();
    for (const Constant& one : elements(*chosen)) value.push_back(index_of(declared_.back(), one));
  }
  TaskConstant& constant = set(names_of(names, value));
  constant.published_value = published(value);
  return constant;
}

TaskConstant& ConstantBinder::colors(const char* name, ColorList& value, int least,
                                     const char* text) {
  const Constant* chosen = add({.name = name,
                                .kind = Kind::kColors,
                                .value = kept_colors(value),
                                .low = static_cast<double>(least),
                                .high = ColorList::kCapacity,
                                .names = color_names(),
                                .description = text});
  if (chosen != nullptr) {
    value.clear();
    for (const Constant& one : elements(*chosen)) value.push_back(*as_color(one));
  }
  TaskConstant& constant = set(kept_colors(value));
  constant.published_value.emplace(palette_table(value));
  return constant;
}

// --- ranges ---

template <class T>
TaskConstant& ConstantBinder::add_range(const char* name, Kind kind, SampledRange<T>& value,
                                        Bounds bounds, const char* unit, const char* text,
                                        VariableName variable) {
  const auto chosen =
      add_numbers(name, kind, ConstantList{value.low, value.high}, bounds, unit, text);
  if (!chosen.empty()) {
    value.low = static_cast<T>(*as_number(chosen.front()));
    value.high = static_cast<T>(*as_number(chosen.back()));
  }
  value.variable = variable;
  value.unit = unit;
  value.constant = declared_.back().changeable() ? name : "";
  return set(ConstantList{value.low, value.high});
}

TaskConstant& ConstantBinder::range(const char* name, SampledRange<int>& value, Bounds bounds,
                                    const char* unit, const char* text, VariableName variable) {
  return add_range(name, Kind::kIntegerRange, value, bounds, unit, text, variable);
}

TaskConstant& ConstantBinder::range(const char* name, SampledRange<double>& value, Bounds bounds,
                                    const char* unit, const char* text, VariableName variable) {
  return add_range(name, Kind::kRealRange, value, bounds, unit, text, variable);
}

TaskConstant& ConstantBinder::steps(const char* name, StepRange& value, Bounds bounds,
                                    const char* text, VariableName variable) {
  return range(name, value, bounds, "control steps", text, variable);
}

// --- the list ---

void ConstantBinder::fixed(const ConstantTable& values) {
  for (const auto& [name, value] : values) declared_.push_back({.name = name, .value = value});
}

std::vector<TaskConstant> ConstantBinder::take() {
  for (const auto& [name, value] : chosen_) check_fixed(name, value);
  return std::move(declared_);
}

void ConstantBinder::check_fixed(const std::string& name, const Constant& chosen) const {
  const auto found = std::ranges::find(declared_, name, &TaskConstant::name);
  const bool known = found != declared_.end();
  if (known && (found->changeable() || is_same_value(chosen, found->published_form()))) return;
  std::vector<TaskConstant> offered = declared_;
  std::erase_if(offered, [](const TaskConstant& constant) { return !constant.changeable(); });
  const std::string names = "This task has: " + join(offered, &TaskConstant::name);
  if (known) {
    refuse_constant(name, in_words(chosen),
                    in_words(found->published_form()) + " allowed: nobody can change it. " + names);
  }
  throw Error(Error::kUnknownId, "no constant named '" + name + "' to change; did you mean '" +
                                     nearest(offered, name, &TaskConstant::name) + "'? " + names);
}

// --- messages ---

std::string in_millimetres(double metres) {
  return std::to_string(std::lround(1000 * metres)) + " mm";
}

void refuse_constant(const std::string& name, const std::string& given,
                     const std::string& allowed) {
  throw Error(Error::kInvalidArgument, "constant '" + name + "': " + given + " given, " + allowed);
}

}  // namespace engram::tasks
