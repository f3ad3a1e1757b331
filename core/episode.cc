#include "core/episode.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>

#include "core/base/error.h"
#include "core/base/join.h"

namespace engram {
namespace {

std::string number(double value) {
  std::ostringstream text;
  text.precision(9);
  text << value;
  return text.str();
}

void check_value(const Draw& draw, double value) {
  const bool whole = !draw.integer || std::nearbyint(value) == value;
  if (whole && value >= draw.low && value <= draw.high) return;
  throw Error(Error::kInvalidArgument,
              "pin '" + draw.name + "': value " + number(value) + " given, " +
                  (draw.integer ? "a whole number" : "a number") + " from " + number(draw.low) +
                  " to " + number(draw.high) + " allowed");
}

void check_distinct(const Pin& pin) {
  for (std::size_t i = 1; i < pin.values.size(); ++i) {
    const auto here = pin.values.begin() + static_cast<std::ptrdiff_t>(i);
    if (std::find(pin.values.begin(), here, *here) == here) continue;
    throw Error(Error::kInvalidArgument, "pin '" + pin.name + "': value " + number(*here) +
                                             " given twice, different values allowed");
  }
}

}  // namespace

PinTable::PinTable(ColumnStore& store, std::vector<Draw> draws) : draws_(std::move(draws)) {
  if (draws_.size() > 64) throw Error(Error::kInternal, "more than 64 draws in a task");
  int width = 0;
  for (const Draw& draw : draws_) {
    offsets_.push_back(width);
    width += draw.width;
  }
  pinned_ = store.add<std::uint64_t>("pinned");
  values_ = store.add<double>("pin_values", width);
}

int PinTable::find(const std::string& name) const {
  const auto found = std::find_if(draws_.begin(), draws_.end(),
                                  [&name](const Draw& draw) { return draw.name == name; });
  return found == draws_.end() ? -1 : static_cast<int>(found - draws_.begin());
}

void PinTable::check(const std::vector<Pin>& pins) const {
  std::uint64_t seen = 0;
  for (const Pin& pin : pins) {
    const int index = find(pin.name);
    if (index < 0) {
      throw Error(Error::kUnknownId, "no draw named '" + pin.name +
                                         "' to pin; this task has: " + join(draws_, &Draw::name));
    }
    if ((seen >> index & 1) != 0) {
      throw Error(Error::kInvalidArgument, "pin '" + pin.name + "' given twice, once allowed");
    }
    seen |= std::uint64_t{1} << index;
    const Draw& draw = draws_[static_cast<std::size_t>(index)];
    if (pin.values.size() != static_cast<std::size_t>(draw.width)) {
      throw Error(Error::kInvalidArgument,
                  "pin '" + pin.name + "': " + std::to_string(pin.values.size()) +
                      " values given, " + std::to_string(draw.width) + " needed");
    }
    for (const double value : pin.values) check_value(draw, value);
    if (draw.distinct) check_distinct(pin);
  }
}

void PinTable::check_saved(std::span<const std::byte> row) const {
  std::uint64_t pinned = 0;
  std::memcpy(&pinned, row.data(), sizeof pinned);
  if (draws_.size() < 64 && pinned >> draws_.size() != 0) {
    throw Error(Error::kInvalidArgument, "snapshot refused: it pins a draw that there is not");
  }
  std::vector<Pin> pins;
  for (std::size_t draw = 0; draw < draws_.size(); ++draw) {
    if ((pinned >> draw & 1) == 0) continue;
    std::vector<double> values(static_cast<std::size_t>(draws_[draw].width));
    std::memcpy(
        values.data(),
        row.data() + sizeof pinned + static_cast<std::size_t>(offsets_[draw]) * sizeof(double),
        values.size() * sizeof(double));
    pins.push_back({draws_[draw].name, std::move(values)});
  }
  check(pins);
}

void PinTable::set(int env, const std::vector<Pin>& pins) const {
  pinned_[env] = 0;
  for (const Pin& pin : pins) {
    const int index = find(pin.name);
    pinned_[env] |= std::uint64_t{1} << index;
    std::copy(pin.values.begin(), pin.values.end(),
              values_.row(env) + offsets_[static_cast<std::size_t>(index)]);
  }
}

const double* PinTable::values(int env, int draw) const {
  if ((pinned_[env] >> draw & 1) == 0) return nullptr;
  return values_.row(env) + offsets_[static_cast<std::size_t>(draw)];
}

int Episode::integer(int draw, int low, int high) const {
  if (const double* value = pinned(draw)) return static_cast<int>(*value);
  return stream(draw).integer(low, high);
}

double Episode::real(int draw, double low, double high) const {
  if (const double* value = pinned(draw)) return *value;
  return stream(draw).uniform(low, high);
}

}  // namespace engram
