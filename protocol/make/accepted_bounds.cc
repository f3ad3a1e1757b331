#include "protocol/make/accepted_bounds.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "core/base/error.h"
#include "core/batch/queries.h"
#include "core/task/option_check.h"
#include "tasks/registry.h"

namespace engram {
namespace {

using Kind = TaskConstant::Kind;
// Whether a task can be made with this bound.
using Accepts = std::function<bool(double)>;

// Makes the batch's task with another value of one constant.
class Trial {
 public:
  Trial(const Batch& batch, const TaskConstant& constant)
      : batch_(batch), constants_(changed_constants(batch.info().constants)) {
    const auto found =
        std::ranges::find(constants_, constant.name, [](const auto& entry) { return entry.first; });
    index_ = static_cast<std::size_t>(found - constants_.begin());
    if (found == constants_.end()) constants_.emplace_back(constant.name, constant.value);
  }

  bool accepts(Constant value) {
    constants_[index_].second = std::move(value);
    try {
      const auto task = make_task(batch_.info().id, constants_);
      const auto* check = dynamic_cast<const OptionCheck*>(task.get());
      if (check != nullptr) check->check_options(Queries(batch_).option_values());
      return true;
    } catch (const Error& error) {
      if (error.kind() != Error::kInvalidArgument) throw;
      return false;
    }
  }

 private:
  const Batch& batch_;
  ConstantTable constants_;
  std::size_t index_;
};

// The accepted value nearest to `bound`, on a grid of `per_unit` points per unit. value: an
// accepted one.
double nearest_accepted(double value, double bound, double per_unit, const Accepts& accepts) {
  if (accepts(bound)) return bound;
  const bool up = bound > value;
  double inner = up ? std::floor(value * per_unit) : std::ceil(value * per_unit);
  double outer = up ? std::ceil(bound * per_unit) : std::floor(bound * per_unit);
  double best = value;
  while (std::abs(outer - inner) > 1) {
    const double middle = std::floor((inner + outer) / 2);
    const double tried = middle / per_unit;
    const bool accepted = (up ? tried <= value : tried >= value) || accepts(tried);
    if (accepted && (up ? tried > value : tried < value)) best = tried;
    (accepted ? inner : outer) = middle;
  }
  return best;
}

// Points per unit of a grid for a range of reals.
double grid_of(const TaskConstant& constant) {
  constexpr double kPoints = 1e4;
  const double decade = std::floor(std::log10(constant.high - constant.low));
  return kPoints / std::pow(10.0, decade);
}

bool is_whole(const TaskConstant& constant) {
  return constant.kind != Kind::kReal && constant.kind != Kind::kReals &&
         constant.kind != Kind::kRealRange;
}

Constant number(const TaskConstant& constant, double value) {
  return is_whole(constant) ? Constant(static_cast<std::int64_t>(value)) : Constant(value);
}

// Narrows both bounds; low and high: numbers of the task as it is.
void narrow(TaskConstant& constant, double low, double high, const Accepts& accepts_low,
            const Accepts& accepts_high) {
  if (constant.low >= constant.high) return;
  const double grid = is_whole(constant) ? 1 : grid_of(constant);
  constant.low = nearest_accepted(low, constant.low, grid, accepts_low);
  constant.high = nearest_accepted(high, constant.high, grid, accepts_high);
}

void narrow_range(TaskConstant& constant, Trial& trial) {
  const auto& ends = std::get<ConstantList>(constant.value.value);
  const auto accepts = [&](double low, double high) {
    ConstantList changed = ends;
    changed.front() = number(constant, low);
    changed.back() = number(constant, high);
    return trial.accepts(std::move(changed));
  };
  const double last = *as_number(ends.back());
  const Accepts low = [&](double bound) { return accepts(bound, last); };
  const Accepts high = [&](double bound) { return accepts(constant.low, bound); };
  narrow(constant, *as_number(ends.front()), *as_number(ends.back()), low, high);
}

// Every number of the list may be replaced by a bound.
void narrow_list(TaskConstant& constant, Trial& trial) {
  const auto& numbers = std::get<ConstantList>(constant.value.value);
  const TaskConstant declared = constant;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    TaskConstant place = declared;
    const Accepts accepts = [&](double bound) {
      ConstantList changed = numbers;
      changed[i] = bound;
      return trial.accepts(std::move(changed));
    };
    const double value = *as_number(numbers[i]);
    narrow(place, value, value, accepts, accepts);
    constant.low = std::max(constant.low, place.low);
    constant.high = std::min(constant.high, place.high);
  }
}

// Tries shorter lists, and longer ones with further names.
void narrow_length(TaskConstant& constant, Trial& trial) {
  const auto& own = std::get<ConstantList>(constant.value.value);
  ConstantList names = own;
  for (const std::string& name : constant.names) {
    if (std::ranges::find(own, Constant(name)) == own.end()) names.emplace_back(name);
  }
  const auto length = static_cast<double>(own.size());
  constant.high = std::min(constant.high, static_cast<double>(names.size()));
  const Accepts accepts = [&](double bound) {
    return trial.accepts(ConstantList(names.begin(), names.begin() + std::lround(bound)));
  };
  narrow(constant, length, length, accepts, accepts);
}

}  // namespace

TaskConstant accepted_bounds(const Batch& batch, TaskConstant constant) {
  Trial trial(batch, constant);
  if (make_task(batch.info().id)->batch_task() != nullptr) return constant;
  switch (constant.kind) {
    case Kind::kFixed:
      break;
    case Kind::kInteger:
    case Kind::kReal: {
      const double value = *as_number(constant.value);
      const Accepts accepts = [&](double bound) { return trial.accepts(number(constant, bound)); };
      narrow(constant, value, value, accepts, accepts);
      break;
    }
    case Kind::kIntegerRange:
    case Kind::kRealRange:
      narrow_range(constant, trial);
      break;
    case Kind::kReals:
      narrow_list(constant, trial);
      break;
    case Kind::kName:
      std::erase_if(constant.names, [&](const std::string& name) { return !trial.accepts(name); });
      break;
    case Kind::kNames:
    case Kind::kColors:
      narrow_length(constant, trial);
      break;
  }
  return constant;
}

}  // namespace engram
