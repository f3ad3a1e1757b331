// Bounds that a description prints are the bounds that are accepted, for all constants of all ids.
#include "protocol/make/accepted_bounds.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <span>
#include <string>

#include "core/task/option_check.h"
#include "protocol/make/make.h"
#include "tasks/family_samples.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using Kind = TaskConstant::Kind;

bool is_made(const std::string& id, const std::string& name, const Constant& value) {
  try {
    const auto task = make_task(id, {{name, value}});
    const auto* check = dynamic_cast<const OptionCheck*>(task.get());
    if (check != nullptr) check->check_options(option_values(task->info().options, {}));
    return true;
  } catch (const Error& error) {
    CHECK(error.kind() == Error::kInvalidArgument);
    return false;
  }
}

// A value of the constant with one number, or one end of a range, in place of its own.
Constant with_number(const TaskConstant& constant, double number, bool high) {
  const bool whole = constant.kind == Kind::kInteger || constant.kind == Kind::kIntegerRange;
  const Constant one = whole ? Constant(std::lround(number)) : Constant(number);
  if (constant.kind == Kind::kInteger || constant.kind == Kind::kReal) return one;
  ConstantList ends = std::get<ConstantList>(constant.value.value);
  (high ? ends.back() : ends.front()) = one;
  return ends;
}

// The next number that is not allowed.
double beyond(const TaskConstant& constant, const TaskConstant& declared, bool high) {
  const bool whole = constant.kind == Kind::kInteger || constant.kind == Kind::kIntegerRange;
  const double step = whole ? 1 : 2e-3 * (declared.high - declared.low);
  return high ? constant.high + step : constant.low - step;
}

void check_numbers(const std::string& id, const TaskConstant& constant,
                   const TaskConstant& declared) {
  CHECK(constant.low >= declared.low);
  CHECK(constant.high <= declared.high);
  for (const bool high : {false, true}) {
    const double bound = high ? constant.high : constant.low;
    INFO("bound " << bound);
    CHECK(is_made(id, constant.name, with_number(constant, bound, high)));
    CHECK_FALSE(
        is_made(id, constant.name, with_number(constant, beyond(constant, declared, high), high)));
  }
  if (constant.kind != Kind::kIntegerRange && constant.kind != Kind::kRealRange) return;
  const bool whole = constant.kind == Kind::kIntegerRange;
  const auto number = [&](double end) {
    return whole ? Constant(std::lround(end)) : Constant(end);
  };
  CHECK(is_made(id, constant.name, ConstantList{number(constant.low), number(constant.high)}));
}

// All places of a list may have either bound, one at a time.
void check_list(const std::string& id, const TaskConstant& constant) {
  const auto& numbers = std::get<ConstantList>(constant.value.value);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    for (const double bound : {constant.low, constant.high}) {
      INFO("place " << i << ", bound " << bound);
      ConstantList changed = numbers;
      changed[i] = bound;
      CHECK(is_made(id, constant.name, changed));
    }
  }
}

void check_length(const std::string& id, const TaskConstant& constant) {
  ConstantList names = std::get<ConstantList>(constant.value.value);
  for (const std::string& name : constant.names) {
    if (std::ranges::find(names, Constant(name)) == names.end()) names.emplace_back(name);
  }
  const auto first = [&](double count) {
    return ConstantList(names.begin(), names.begin() + std::lround(count));
  };
  CHECK(is_made(id, constant.name, first(constant.low)));
  CHECK(is_made(id, constant.name, first(constant.high)));
  if (constant.low > 1) CHECK_FALSE(is_made(id, constant.name, first(constant.low - 1)));
  if (constant.high < static_cast<double>(names.size())) {
    CHECK_FALSE(is_made(id, constant.name, first(constant.high + 1)));
  }
}

void check_names(const std::string& id, const TaskConstant& constant,
                 const TaskConstant& declared) {
  for (const std::string& name : declared.names) {
    const bool listed = std::ranges::find(constant.names, name) != constant.names.end();
    CHECK(is_made(id, constant.name, name) == listed);
  }
}

void check_bounds(const std::string& id, const TaskConstant& constant,
                  const TaskConstant& declared) {
  switch (constant.kind) {
    case Kind::kFixed:
      return;
    case Kind::kInteger:
    case Kind::kReal:
    case Kind::kIntegerRange:
    case Kind::kRealRange:
      return check_numbers(id, constant, declared);
    case Kind::kReals:
      return check_list(id, constant);
    case Kind::kName:
      return check_names(id, constant, declared);
    case Kind::kNames:
    case Kind::kColors:
      return check_length(id, constant);
  }
}

void check_all_bounds(std::span<const std::string> ids) {
  for (const std::string& id : ids) {
    const auto batch = test::make_env(id);
    for (const TaskConstant& declared : batch->info().constants) {
      if (!declared.changeable()) continue;
      INFO(id << " " << declared.name);
      check_bounds(id, accepted_bounds(*batch, declared), declared);
    }
  }
}

TEST_CASE("Printed bounds are the accepted ones, for all constants of each family", "[bounds]") {
  check_all_bounds(one_of_each_family());
}

TEST_CASE("Printed bounds are the accepted ones, for all constants of all ids", "[bounds][long]") {
  check_all_bounds(test::implemented_ids());
}

TaskConstant bounds_of(const Batch& batch, std::string_view name) {
  const auto& constants = batch.info().constants;
  return accepted_bounds(batch, *std::ranges::find(constants, name, &TaskConstant::name));
}

TEST_CASE("Bounds of a shell game follow its other constants", "[bounds]") {
  const char* const id = "ShellGameTouch-VLA-v0";
  const auto own = test::make_env(id);
  CHECK(bounds_of(*own, "GOAL_THRESH").low == Approx(0.069).margin(1e-3));
  CHECK(bounds_of(*own, "GOAL_THRESH").high < 0.2);
  CHECK(bounds_of(*own, "MUG_SCALE").high < 2);
  const auto apart = test::make_env(id, MakeOptions{{}, {{"MIN_DIST", 0.3}}, 0});
  CHECK(bounds_of(*apart, "GOAL_THRESH").high == Approx(0.3).margin(1e-3));
  CHECK(bounds_of(*apart, "MIN_DIST").low < 0.3);
}

TEST_CASE("Bounds of a goal region follow the option that defines success", "[bounds]") {
  MakeOptions by_mug;
  by_mug.task_options = {{"mug_at_goal", 1}};
  const auto mug = test::make_env("ShellGamePush-VLA-v0", by_mug);
  const auto ball = test::make_env("ShellGamePush-VLA-v0");
  for (const auto* batch : {mug.get(), ball.get()}) {
    MakeOptions options = batch == mug.get() ? by_mug : MakeOptions{};
    const TaskConstant found = bounds_of(*batch, "GOAL_THRESH");
    for (const double bound : {found.low, found.high}) {
      options.constants = {{"GOAL_THRESH", bound}};
      CHECK_NOTHROW(test::make_env("ShellGamePush-VLA-v0", options));
    }
  }
  CHECK(bounds_of(*mug, "GOAL_THRESH").high < bounds_of(*ball, "GOAL_THRESH").high);
}

}  // namespace
}  // namespace engram
