#include "protocol/make/constant_warnings.h"

#include <algorithm>
#include <memory>
#include <optional>

#include "core/base/join.h"
#include "protocol/make/unused_constants.h"
#include "tasks/registry.h"

namespace engram {
namespace {

// An allowed value below which the oracle solves less than nine of ten episodes of some of the
// tasks; measured over 50 episodes of each.
struct OracleLimit {
  std::string_view families;  // beginning of their names
  std::string_view constant;
  double least = 0;
};

constexpr OracleLimit kLimits[] = {
    {"Remember", "GOAL_THRESH", 0.01},
    {"FindImposter", "GOAL_THRESH", 0.01},
    {"Intercept", "VELOCITY_RANGE", 0.1},
};

// The value, or the lower end of a range.
std::optional<double> least_of(const Constant& value) {
  const auto* range = std::get_if<ConstantList>(&value.value);
  return range == nullptr || range->empty() ? as_number(value) : as_number(range->front());
}

bool fails(const OracleLimit& limit, std::string_view family, const std::string& constant,
           const Constant& value) {
  return constant == limit.constant && family.starts_with(limit.families) &&
         least_of(value).value_or(limit.least) < limit.least;
}

std::string warning(const OracleLimit& limit, const Constant& value) {
  const bool is_range = std::holds_alternative<ConstantList>(value.value);
  return std::string(limit.constant) + "=" + in_words(value) +
         (is_range ? " begins below " : " is below ") + shortest(limit.least) +
         ", where the oracle itself may fail; measure it beside your policy";
}

}  // namespace

std::vector<std::string> constant_warnings(const TaskInfo& info, const BatchOptions& options) {
  std::vector<std::string> warnings = unused_constants(info, options);
  for (const auto& [name, value] : changed_constants(info.constants)) {
    for (const OracleLimit& limit : kLimits) {
      if (fails(limit, info.family, name, value)) warnings.push_back(warning(limit, value));
    }
  }
  return warnings;
}

std::vector<std::string> constant_warnings(std::string_view id, const MakeOptions& options) {
  if (options.constants.empty() && require_entry(id).constants == nullptr) return {};
  return constant_warnings(make_task(id, options.constants, options.max_episode_steps)->info(),
                           options);
}

}  // namespace engram
