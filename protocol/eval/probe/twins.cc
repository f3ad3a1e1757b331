#include "protocol/eval/probe/twins.h"

#include <algorithm>
#include <set>
#include <string>

#include "core/base/join.h"
#include "core/task/episode.h"
#include "protocol/eval/probe/answers.h"
#include "protocol/eval/probe/counterfactual.h"

namespace engram {
namespace {

// Places in a group.
enum : std::size_t {
  kOne,
  kOther,
  kOneWiped,
  kOtherWiped,
  kOneInOther,  // the past of the one, then the scene of the other
  kOtherInOne,
  kUnchanged,  // a past, and the same but for something irrelevant
  kChanged,
  kGroup,
};

TrialGroup unplayed() { return TrialGroup(kGroup, Trial{.draw = {}, .question = -1}); }

TrialGroup make_group(const MemoryFacts& facts, Lookahead& lookahead, std::uint64_t seed) {
  CounterfactualSampler chooser(lookahead, facts, seed);
  TrialGroup group = unplayed();
  const EpisodeDraw one{seed, chooser.any()};
  const auto second = chooser.other_answer(one.pins);
  if (!second) return group;
  const EpisodeDraw other{seed, *second};
  const int ends[] = {lookahead.cue_end(one), lookahead.cue_end(other)};
  if (std::ranges::min(ends) < 0) return group;
  const int question = std::ranges::max(ends);
  const Trial plain{.draw = one, .question = question, .until_answer = true};
  for (std::size_t i = kOne; i <= kOtherInOne; ++i) {
    group[i] = plain;
    if (i % 2 == 1) group[i].draw = other;
    group[i].wiped = i == kOneWiped || i == kOtherWiped;
    if (i != kOne) group[i].twin = kOne;
  }
  if (facts.cue_by_hand) {
    // Only in one scene do the robots stand alike.
    group[kOther].twin = -1;
    group[kOtherWiped].twin = kOther;
    group[kOneInOther].twin = kOther;
  }
  group[kOneInOther].scene = lookahead.scene_at(other, question);
  group[kOtherInOne].scene = lookahead.scene_at(one, question);
  if (const auto change = chooser.irrelevant_change(one.pins)) {
    group[kUnchanged] = {.draw = change->one, .question = change->question, .until_answer = true};
    group[kChanged] = {.draw = change->other,
                       .question = change->question,
                       .until_answer = true,
                       .twin = kUnchanged};
    if (change->joins) group[kChanged].scene = lookahead.scene_at(change->one, change->question);
  }
  return group;
}

// The presents of trials that have been compared.
struct Presents {
  int compared = 0;
  int equal = 0;

  void add(const TrialResult& trial) {
    if (trial.compared == 0) return;
    ++compared;
    equal += trial.same_present;
  }
  Json document() const { return JsonTable{{"compared", compared}, {"equal", equal}}; }
};

Json document_of(const ProbeTask& task, const ConditionResults& results) {
  const bool any_order = task.facts().any_order;
  std::vector<bool> follow;
  std::vector<bool> both;
  std::vector<bool> answered;
  std::vector<bool> wiped;
  std::vector<bool> past;
  std::vector<bool> scene;
  std::vector<bool> stay;
  std::set<std::string> parts;  // what has changed in them
  Presents twins;
  Presents changed;
  for (const std::vector<TrialResult>& group : results) {
    if (group[kOne].played == 0 || group[kOther].played == 0) continue;
    for (const std::size_t i : {kOne, kOther}) {
      follow.push_back(group[i].correct != 0);
      answered.push_back(group[i].answered != 0);
      wiped.push_back(group[i + kOneWiped].correct != 0);
      const TrialResult& swapped = group[i + kOneInOther];
      past.push_back(group[i].correct != 0 &&
                     answers_as(swapped, group[i], task.facts().answer_cut));
      scene.push_back(swapped.correct != 0);
    }
    both.push_back(group[kOne].correct != 0 && group[kOther].correct != 0);
    for (std::size_t i = kOther; i <= kOtherInOne; ++i) twins.add(group[i]);
    if (group[kChanged].played == 0) continue;
    parts.insert(group[kChanged].exchanged != 0 ? std::string(kRobotNoiseVariable)
                                                : irrelevant_part(task.facts(), task.info));
    stay.push_back(same_answer(group[kUnchanged], group[kChanged], any_order));
    changed.add(group[kChanged]);
  }
  if (both.empty()) {
    return JsonTable{{"skipped", "no two pasts with different answers and a question were found"}};
  }
  return JsonTable{
      {"chance", task.info.answer_chance()},
      {"pairs", both.size()},
      {"presents", twins.document()},
      {"follow", rate_document(follow, 2)},
      {"both_follow", rate_document(both)},
      {"answered", rate_document(answered, 2)},
      {"wiped_follow", rate_document(wiped, 2)},
      {"swapped", JsonTable{{"past", rate_document(past, 2)}, {"scene", rate_document(scene, 2)}}},
      {"stay", stay.empty() ? Json() : rate_document(stay)},
      {"stay_by", parts.empty() ? Json() : Json(join(parts))},
      {"stay_presents", stay.empty() ? Json() : changed.document()}};
}

}  // namespace

ProbePlan plan_twins(const ProbeTask& task) {
  if (const std::string reason = task.no_counterfactuals(); !reason.empty())
    return skipped_plan(reason);
  ProbeCondition condition{.entry = task.entry, .constants = task.constants};
  condition.trials = [&facts = task.facts()](Lookahead& lookahead, std::uint64_t seed) {
    return make_group(facts, lookahead, seed);
  };
  return {{std::move(condition)}, [task](const std::vector<ConditionResults>& results) {
            return document_of(task, results.front());
          }};
}

}  // namespace engram
