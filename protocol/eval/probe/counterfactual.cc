#include "protocol/eval/probe/counterfactual.h"

#include <algorithm>
#include <numeric>

namespace engram {
namespace {

constexpr int kTries = 64;

const RandomVariable* draw_of_constant(const TaskInfo& info, std::string_view constant) {
  const auto found = std::ranges::find(info.random_variables, constant, &RandomVariable::constant);
  return constant.empty() || found == info.random_variables.end() ? nullptr : &*found;
}

const RandomVariable* draw_of_name(const TaskInfo& info, std::string_view name) {
  const auto found = std::ranges::find(info.random_variables, name, &RandomVariable::name);
  return found == info.random_variables.end() ? nullptr : &*found;
}

bool has_choice(const RandomVariable* draw) { return draw != nullptr && draw->low < draw->high; }

}  // namespace

std::string_view hidden_draw(const MemoryFacts& facts, const TaskInfo& info) {
  return facts.hidden.empty() ? std::string_view(info.hidden_variable) : facts.hidden;
}

std::string irrelevant_part(const MemoryFacts& facts, const TaskInfo& info) {
  switch (facts.irrelevant) {
    case CounterfactualChange::kDraw:
      return std::string(facts.irrelevant_draw);
    case CounterfactualChange::kOrder:
      return "order of " + std::string(hidden_draw(facts, info));
    case CounterfactualChange::kSameAnswer:
      return std::string(hidden_draw(facts, info));
    case CounterfactualChange::kStart:
      break;
  }
  return kRobotNoiseVariable;
}

CounterfactualSampler::CounterfactualSampler(Lookahead& lookahead, const MemoryFacts& facts,
                                             std::uint64_t seed)
    : lookahead_(lookahead),
      facts_(facts),
      seed_(seed),
      random_(seed, 0, kPurposeProbePast),
      hidden_(find(hidden_draw(facts, lookahead.batch().info()))) {
  if (hidden_ == nullptr) throw Error(Error::kInternal, "probe of a task that hides nothing");
}

const RandomVariable* CounterfactualSampler::find(std::string_view name) const {
  return draw_of_name(lookahead_.batch().info(), name);
}

std::vector<double> CounterfactualSampler::values_of(const RandomVariable& variable) {
  std::vector<double> values(static_cast<std::size_t>(variable.width));
  for (std::size_t i = 0; i < values.size(); ++i) {
    do {
      values[i] = variable.integer ? random_.integer(static_cast<int>(variable.low),
                                                     static_cast<int>(variable.high))
                                   : random_.uniform(variable.low, variable.high);
    } while (variable.distinct &&
             std::find(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(i),
                       values[i]) != values.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return values;
}

std::vector<Pin> CounterfactualSampler::any() { return {{hidden_->name, values_of(*hidden_)}}; }

std::vector<double> CounterfactualSampler::answer_of(const std::vector<Pin>& past) {
  std::vector<double> answer = lookahead_.right_answer({seed_, past});
  if (answer.empty()) answer = past.front().values;
  if (facts_.any_order) std::ranges::sort(answer);
  return answer;
}

std::optional<std::vector<Pin>> CounterfactualSampler::other_answer(const std::vector<Pin>& past) {
  const std::vector<double> answer = answer_of(past);
  for (int i = 0; i < kTries; ++i) {
    std::vector<Pin> other = any();
    if (answer_of(other) != answer) return other;
  }
  // Items of one kind differ in their number alone.
  const RandomVariable* items = find(facts_.items);
  if (!has_choice(items)) return std::nullopt;
  for (int i = 0; i < kTries; ++i) {
    std::vector<Pin> other = past;
    other.push_back({items->name, values_of(*items)});
    if (answer_of(other) != answer) return other;
  }
  return std::nullopt;
}

// Both questions come when neither cue shows any more.
std::optional<CounterfactualSampler::IrrelevantChange> CounterfactualSampler::with_questions(
    std::vector<Pin> one, std::vector<Pin> other) {
  IrrelevantChange change{{seed_, std::move(one)}, {seed_, std::move(other)}};
  const int first = lookahead_.cue_end(change.one);
  const int second = lookahead_.cue_end(change.other);
  if (first < 0 || second < 0) return std::nullopt;
  change.question = std::max(first, second);
  return change;
}

std::optional<CounterfactualSampler::IrrelevantChange> CounterfactualSampler::irrelevant_change(
    const std::vector<Pin>& past) {
  std::optional<IrrelevantChange> change = own_change(past);
  return change ? change : change_start(past);
}

std::optional<CounterfactualSampler::IrrelevantChange> CounterfactualSampler::own_change(
    const std::vector<Pin>& past) {
  switch (facts_.irrelevant) {
    case CounterfactualChange::kDraw:
      return change_draw(past);
    case CounterfactualChange::kOrder:
      return change_order(past);
    case CounterfactualChange::kSameAnswer:
      return change_values(past);
    case CounterfactualChange::kStart:
      break;
  }
  return std::nullopt;
}

std::optional<CounterfactualSampler::IrrelevantChange> CounterfactualSampler::change_order(
    const std::vector<Pin>& past) {
  std::vector<Pin> other = past;
  std::ranges::reverse(other.front().values);
  if (other.front().values == past.front().values) return std::nullopt;
  return with_questions(past, other);
}

std::optional<CounterfactualSampler::IrrelevantChange> CounterfactualSampler::change_values(
    const std::vector<Pin>& past) {
  const std::vector<double> answer = answer_of(past);
  for (int i = 0; i < kTries; ++i) {
    std::vector<Pin> other = any();
    if (other.front().values != past.front().values && answer_of(other) == answer) {
      return with_questions(past, other);
    }
  }
  return std::nullopt;
}

// The arm is seen in every step, so the presents are alike only in the same scene.
std::optional<CounterfactualSampler::IrrelevantChange> CounterfactualSampler::change_start(
    const std::vector<Pin>& past) {
  const double noise = lookahead_.batch().options().robot_init_qpos_noise;
  if (noise == 0) return std::nullopt;
  std::vector<Pin> other = past;
  Pin& start = other.emplace_back(Pin{kRobotNoiseVariable, std::vector<double>(kArmJoints)});
  for (double& joint : start.values) joint = std::clamp(noise * random_.normal(), -1.0, 1.0);
  std::optional<IrrelevantChange> change = with_questions(past, other);
  if (change) change->joins = true;
  return change;
}

// Where there is a delay, it takes up the difference, so that the question comes at one time.
std::optional<CounterfactualSampler::IrrelevantChange> CounterfactualSampler::change_draw(
    const std::vector<Pin>& past) {
  const RandomVariable* draw = find(facts_.irrelevant_draw);
  const RandomVariable* delay = draw_of_constant(lookahead_.batch().info(), facts_.delay);
  if (!has_choice(draw)) return std::nullopt;
  for (int i = 0; i < kTries; ++i) {
    std::vector<Pin> one = past;
    std::vector<Pin> other = past;
    one.push_back({draw->name, values_of(*draw)});
    other.push_back({draw->name, values_of(*draw)});
    if (one.back().values == other.back().values) continue;
    std::optional<IrrelevantChange> change = with_questions(one, other);
    if (!change || delay == nullptr) return change;
    const int longer = lookahead_.cue_end(change->other) - lookahead_.cue_end(change->one);
    const auto least = static_cast<int>(delay->low) + std::max(0, longer);
    const auto most = static_cast<int>(delay->high) + std::min(0, longer);
    if (least > most) continue;
    const int steps = random_.integer(least, most);
    change->question = lookahead_.cue_end(change->one) + steps;
    change->one.pins.push_back({delay->name, {static_cast<double>(steps)}});
    change->other.pins.push_back({delay->name, {static_cast<double>(steps - longer)}});
    return change;
  }
  return std::nullopt;
}

}  // namespace engram
