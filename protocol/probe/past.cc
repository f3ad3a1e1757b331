#include "protocol/probe/past.h"

#include <algorithm>
#include <numeric>

namespace engram {
namespace {

constexpr int kTries = 64;

}  // namespace

PastChooser::PastChooser(Lookahead& lookahead, const MemoryFacts& facts, std::uint64_t seed)
    : lookahead_(lookahead),
      facts_(facts),
      seed_(seed),
      random_(seed, 0, kPurposeProbePast),
      hidden_(find(lookahead.env().info().hidden_variable)) {
  if (hidden_ == nullptr) throw Error(Error::kInternal, "probe of a task that hides nothing");
}

const RandomVariable* PastChooser::find(std::string_view name) const {
  const std::vector<RandomVariable>& draws = lookahead_.env().info().random_variables;
  const auto found = std::ranges::find(draws, name, &RandomVariable::name);
  return found == draws.end() ? nullptr : &*found;
}

std::vector<double> PastChooser::values_of(const RandomVariable& variable) {
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

std::vector<Pin> PastChooser::any() { return {{hidden_->name, values_of(*hidden_)}}; }

std::vector<double> PastChooser::answer_of(const std::vector<Pin>& past) {
  std::vector<double> answer = lookahead_.right_answer({seed_, past});
  if (answer.empty()) answer = past.front().values;
  if (facts_.any_order) std::ranges::sort(answer);
  return answer;
}

std::optional<std::vector<Pin>> PastChooser::other_answer(const std::vector<Pin>& past) {
  const std::vector<double> answer = answer_of(past);
  for (int i = 0; i < kTries; ++i) {
    std::vector<Pin> other = any();
    if (answer_of(other) != answer) return other;
  }
  return std::nullopt;
}

// Both questions come when neither cue shows any more.
std::optional<PastChooser::IrrelevantChange> PastChooser::with_questions(std::vector<Pin> one,
                                                                         std::vector<Pin> other) {
  IrrelevantChange change{{seed_, std::move(one)}, {seed_, std::move(other)}};
  const int first = lookahead_.cue_end(change.one);
  const int second = lookahead_.cue_end(change.other);
  if (first < 0 || second < 0) return std::nullopt;
  change.question = std::max(first, second);
  return change;
}

std::optional<PastChooser::IrrelevantChange> PastChooser::irrelevant_change(
    const std::vector<Pin>& past) {
  switch (facts_.irrelevant) {
    case PastChange::kNone:
      return std::nullopt;
    case PastChange::kDraw:
      return change_draw(past);
    case PastChange::kOrder: {
      std::vector<Pin> other = past;
      std::ranges::reverse(other.front().values);
      if (other.front().values == past.front().values) return std::nullopt;
      return with_questions(past, other);
    }
    case PastChange::kSameAnswer:
      break;
  }
  const std::vector<double> answer = answer_of(past);
  for (int i = 0; i < kTries; ++i) {
    std::vector<Pin> other = any();
    if (other.front().values != past.front().values && answer_of(other) == answer) {
      return with_questions(past, other);
    }
  }
  return std::nullopt;
}

// Where there is a delay, it takes up the difference, so that the question comes at one time.
std::optional<PastChooser::IrrelevantChange> PastChooser::change_draw(
    const std::vector<Pin>& past) {
  const RandomVariable* draw = find(facts_.irrelevant_draw);
  if (draw == nullptr || draw->low == draw->high) return std::nullopt;
  const std::vector<RandomVariable>& draws = lookahead_.env().info().random_variables;
  const auto delay = facts_.delay.empty()
                         ? draws.end()
                         : std::ranges::find(draws, facts_.delay, &RandomVariable::constant);
  for (int i = 0; i < kTries; ++i) {
    std::vector<Pin> one = past;
    std::vector<Pin> other = past;
    one.push_back({draw->name, values_of(*draw)});
    other.push_back({draw->name, values_of(*draw)});
    if (one.back().values == other.back().values) continue;
    std::optional<IrrelevantChange> change = with_questions(one, other);
    if (!change || delay == draws.end()) return change;
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
