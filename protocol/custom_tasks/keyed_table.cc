#include "protocol/custom_tasks/keyed_table.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/join.h"
#include "core/base/nearest.h"

namespace engram {

KeyedTable::KeyedTable(const Json& document, std::string what)
    : document_(document), what_(std::move(what)) {
  if (!is_table(document)) refuse("a table of names and values needed");
}

void KeyedTable::refuse(const std::string& why) const {
  throw Error(Error::kInvalidArgument, what_ + ": " + why);
}

void KeyedTable::allow(std::span<const char* const> keys) const {
  for (const auto& [key, value] : table(document_)) {
    if (std::ranges::find(keys, std::string_view(key)) != keys.end()) continue;
    refuse("it has '" + key + "'; did you mean '" + std::string(nearest(keys, key)) + "'?");
  }
}

const Json& KeyedTable::value(std::string_view key) const {
  const Json* found = find(document_, key);
  if (found == nullptr) refuse("'" + std::string(key) + "' is missing");
  return *found;
}

std::string KeyedTable::text(std::string_view key) const {
  const auto* found = std::get_if<std::string>(&value(key).value);
  if (found == nullptr) refuse("'" + std::string(key) + "' has to be a text");
  return *found;
}

double KeyedTable::number(std::string_view key) const {
  const Json& found = value(key);
  if (!is_number(found) || !std::isfinite(engram::number(found))) {
    refuse("'" + std::string(key) + "' has to be a finite number");
  }
  return engram::number(found);
}

int KeyedTable::integer(std::string_view key, int least, int most) const {
  const double found = number(key);
  if (std::trunc(found) != found || found < least || found > most) {
    refuse("'" + std::string(key) + "': " + shortest(found) + " given, a whole number from " +
           std::to_string(least) + " to " + std::to_string(most) + " allowed");
  }
  return static_cast<int>(found);
}

std::vector<double> KeyedTable::numbers(std::string_view key, std::size_t least,
                                        std::size_t most) const {
  std::vector<double> values;
  for (const Json& one : list(key)) {
    if (!is_number(one) || !std::isfinite(engram::number(one))) {
      refuse("'" + std::string(key) + "' has to be a list of finite numbers");
    }
    values.push_back(engram::number(one));
  }
  if (values.size() < least || values.size() > most) {
    refuse("'" + std::string(key) + "': " + std::to_string(values.size()) + " numbers given, " +
           std::to_string(least) + (least == most ? "" : " to " + std::to_string(most)) +
           " needed");
  }
  return values;
}

const JsonList& KeyedTable::list(std::string_view key) const {
  static const JsonList none;
  if (!has(key)) return none;
  const auto* found = std::get_if<JsonList>(&value(key).value);
  if (found == nullptr) refuse("'" + std::string(key) + "' has to be a list");
  return *found;
}

std::string KeyedTable::text(std::string_view key, std::string_view otherwise) const {
  return has(key) ? text(key) : std::string(otherwise);
}

double KeyedTable::number(std::string_view key, double otherwise) const {
  return has(key) ? number(key) : otherwise;
}

bool KeyedTable::truth(std::string_view key, bool otherwise) const {
  if (!has(key)) return otherwise;
  const auto* found = std::get_if<bool>(&value(key).value);
  if (found == nullptr) refuse("'" + std::string(key) + "' has to be true or false");
  return *found;
}

std::vector<std::string> KeyedTable::texts(std::string_view key) const {
  std::vector<std::string> values;
  for (const Json& one : list(key)) {
    const auto* found = std::get_if<std::string>(&one.value);
    if (found == nullptr) refuse("'" + std::string(key) + "' has to be a list of texts");
    values.push_back(*found);
  }
  return values;
}

std::size_t KeyedTable::choice(std::string_view key, std::span<const char* const> names) const {
  const std::string name = text(key);
  const auto found = std::ranges::find(names, std::string_view(name));
  if (found == names.end()) {
    refuse("'" + std::string(key) + "': '" + name + "' given, allowed are: " + join(names));
  }
  return static_cast<std::size_t>(found - names.begin());
}

}  // namespace engram
