#include "protocol/eval/probe/capacity.h"

#include <algorithm>
#include <cmath>

namespace engram {
namespace {

constexpr int kPoints = 5;

// What there is more or less of: a constant, or a draw that is pinned.
struct Quantity {
  int low = 0;
  int high = 0;
  int own = 0;  // the task's own value
  bool drawn = false;
};

Quantity quantity_of(const ProbeTask& task) {
  const std::string_view name = task.facts().items;
  const auto draw = std::ranges::find(task.info.random_variables, name, &RandomVariable::name);
  if (draw != task.info.random_variables.end()) {
    return {static_cast<int>(draw->low), static_cast<int>(draw->high), static_cast<int>(draw->low),
            true};
  }
  const auto constant = std::ranges::find(task.info.constants, name, &TaskConstant::name);
  return {static_cast<int>(constant->low), static_cast<int>(constant->high),
          static_cast<int>(number(constant->value)), false};
}

// At equal distances from the least to the greatest, and the task's own.
std::vector<int> values_of(const Quantity& quantity) {
  std::vector<int> values = {quantity.own};
  for (int i = 0; i < kPoints; ++i) {
    const double share = static_cast<double>(i) / (kPoints - 1);
    values.push_back(quantity.low +
                     static_cast<int>(std::lround(share * (quantity.high - quantity.low))));
  }
  std::ranges::sort(values);
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}

struct CapacityPoint {
  int value = 0;
  ConstantTable constants = {};
  std::string skipped = {};  // why it is not played
  double chance = 0;
  double answer_chance = 0;
};

// Longer episodes for more of them, so that there is time.
CapacityPoint point_of(const ProbeTask& task, const Quantity& quantity, int value,
                       const std::function<bool(const ConstantTable&)>& fits) {
  CapacityPoint point{.value = value, .constants = task.constants};
  if (!quantity.drawn && value != quantity.own) {
    const double times = std::max(1.0, value / static_cast<double>(quantity.own));
    point.constants =
        task.with({{std::string(task.facts().items), value},
                   {kHorizonConstant, static_cast<int>(std::ceil(times * task.info.horizon))}});
  }
  try {
    const TaskInfo info = make_task(task.entry->id, point.constants)->info();
    point.chance = info.chance();
    point.answer_chance = info.answer_chance();
    if (!fits(point.constants)) point.skipped = "the observation has another number of values";
  } catch (const Error& error) {
    point.skipped = error.what();
  }
  return point;
}

ProbeCondition condition_of(const ProbeTask& task, const Quantity& quantity,
                            const CapacityPoint& point) {
  ProbeCondition condition{.entry = task.entry, .constants = point.constants};
  std::vector<Pin> pins;
  if (quantity.drawn) {
    pins.push_back({std::string(task.facts().items), {static_cast<double>(point.value)}});
  }
  condition.trials = [pins](Lookahead& /*lookahead*/, std::uint64_t seed) {
    return TrialGroup{Trial{.draw = {seed, pins}}};
  };
  return condition;
}

double rate_of(const Json& share) {
  const Json& rate = part(share, "rate");
  return is_null(rate) ? 0 : number(rate);
}

// The part that is reached of what the oracle's motor skill allows above chance.
Json recall(double rate, double oracle, double chance) {
  return oracle > chance ? Json((rate - chance) / (oracle - chance)) : Json();
}

// results: the policy's, then the oracle's.
Json document_of(const CapacityPoint& point, const ConditionResults& own,
                 const ConditionResults& oracle) {
  const Json success = success_document(own);
  const Json baseline = success_document(oracle);
  const Json answer = first_answer_document(own);
  const Json answer_ceiling = first_answer_document(oracle);
  return JsonTable{{"items", point.value},
                   {"success", success},
                   {"first_answer", answer},
                   {"chance", point.chance},
                   {"answer_chance", point.answer_chance},
                   {"oracle", JsonTable{{"success", baseline}, {"first_answer", answer_ceiling}}},
                   {"success_of_oracle", recall(rate_of(success), rate_of(baseline), point.chance)},
                   {"first_answer_of_oracle",
                    recall(rate_of(answer), rate_of(answer_ceiling), point.answer_chance)}};
}

}  // namespace

ProbePlan plan_capacity(const ProbeTask& task,
                        const std::function<bool(const ConstantTable& constants)>& fits) {
  if (task.facts().items.empty()) {
    return skipped_plan("no constant and no draw of the task says how much there is to remember");
  }
  const Quantity quantity = quantity_of(task);
  std::vector<CapacityPoint> points;
  ProbePlan plan;
  for (const int value : values_of(quantity)) {
    const CapacityPoint& point = points.emplace_back(point_of(task, quantity, value, fits));
    if (!point.skipped.empty()) continue;
    plan.conditions.push_back(condition_of(task, quantity, point));
    plan.conditions.push_back(plan.conditions.back());
    plan.conditions.back().control = Policy::kOracle;
  }
  plan.document =
      [points, items = task.facts().items](const std::vector<ConditionResults>& results) -> Json {
    JsonList rows;
    std::size_t next = 0;
    for (const CapacityPoint& point : points) {
      if (!point.skipped.empty()) {
        rows.emplace_back(JsonTable{{"items", point.value}, {"skipped", point.skipped}});
        continue;
      }
      rows.emplace_back(document_of(point, results[next], results[next + 1]));
      next += 2;
    }
    return JsonTable{{"quantity", items}, {"points", rows}};
  };
  return plan;
}

}  // namespace engram
