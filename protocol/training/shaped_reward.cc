#include "protocol/training/shaped_reward.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "core/base/index.h"

namespace engram::training {
namespace {

// The column of a term; -1 where the reward has none.
int column_of(const TaskInfo& info, std::string_view name) {
  const auto found = std::ranges::find_if(info.reward_terms,
                                          [name](const Field& term) { return term.name == name; });
  return found == info.reward_terms.end() ? -1
                                          : static_cast<int>(found - info.reward_terms.begin());
}

// The term of kThere that all rewards have which pay standing still; null if there is none.
const char* where_to_stand_still(const Batch& batch) {
  for (const char* const name : kThere) {
    int paying = 0;
    int without = 0;
    for (int i = 0; i < batch.num_parts(); ++i) {
      const TaskInfo& info = batch.part(i).info();
      if (column_of(info, kStill) < 0) continue;
      ++paying;
      without += column_of(info, name) < 0 ? 1 : 0;
    }
    if (paying > 0 && without == 0) return name;
  }
  return nullptr;
}

// The share of a term that counts, 0 to 1; 0 of NaN.
float share_of(float value, bool is_distance) {
  const float share = is_distance ? 1 - value / static_cast<float>(kRange) : value;
  return share > 0 ? std::min(share, 1.0F) : 0.0F;
}

}  // namespace

ShapedReward::ShapedReward(const Batch& batch, const Options& options)
    : options_(options), episodes_(at(batch.num_envs())) {
  const char* const place = options.still > 0 ? where_to_stand_still(batch) : nullptr;
  for (int i = 0; i < batch.num_parts(); ++i) {
    const TaskInfo& info = batch.part(i).info();
    parts_.push_back({terms_of(info, options.still, place), info.horizon});
    part_of_.insert(part_of_.end(), at(batch.part(i).num_envs()), i);
  }
}

std::vector<ShapedReward::Term> ShapedReward::terms_of(const TaskInfo& info, double still,
                                                       const char* place) {
  std::vector<Term> terms;
  const auto add = [&](const TermRule& rule) {
    const std::string_view name = rule.name;
    const int column = column_of(info, name);
    if (column == kNone) return;
    terms.push_back({column, rule.weight, name.ends_with("dist"), column_of(info, rule.until),
                     column_of(info, rule.since)});
  };
  for (const TermRule& rule : kTerms) add(rule);
  if (place != nullptr) add({kStill, still, "", place});
  std::ranges::sort(terms, {}, &Term::column);
  return terms;
}

void ShapedReward::begin(int env) { episodes_[at(env)] = {}; }

float ShapedReward::step(int env, const StepResult& result) {
  Episode& episode = episodes_[at(env)];
  const Part& part = parts_[at(part_of_[at(env)])];
  float reward = result.reward;
  if (options_.potential > 0) {
    const bool has_none = result.failed || result.idle;
    const double potential = has_none ? 0 : potential_of(part, result);
    const double difference = options_.gamma * potential - episode.potential;
    reward = result.idle ? 0.0F : static_cast<float>(difference);
    episode.potential = potential;
  }
  if (options_.bonus > 0) {
    const bool first = result.success_once && !episode.succeeded && !result.idle;
    const double held = first ? held_value(part, result.elapsed) : 0;
    reward = static_cast<float>(static_cast<double>(reward) + held);
    if (episode.succeeded || result.idle) reward = 0;
    episode.succeeded |= first;
  }
  return reward;
}

double ShapedReward::potential_of(const Part& part, const StepResult& result) const {
  const auto is_over = [&](int column) { return result.reward_terms[column] > 0.5F; };
  double sum = 0;
  for (const Term& term : part.terms) {
    float share = share_of(result.reward_terms[term.column], term.is_distance);
    if (term.until != kNone && is_over(term.until)) share = 1;
    if (term.since != kNone && !is_over(term.since)) share = 0;
    sum += static_cast<double>(share) * term.weight;
  }
  return options_.potential * static_cast<double>(std::clamp(result.reward, 0.0F, 1.0F)) + sum;
}

// Pay for the steps that are left, this one included.
double ShapedReward::held_value(const Part& part, std::int32_t elapsed) const {
  const double left = std::max(part.horizon - elapsed, 0) + 1;
  const double gamma = options_.gamma;
  return options_.bonus * (gamma == 1 ? left : (1 - std::pow(gamma, left)) / (1 - gamma));
}

}  // namespace engram::training
