#include "protocol/eval/probe/interference.h"

#include "protocol/eval/probe/counterfactual.h"

namespace engram {
namespace {

constexpr int kOthers[] = {0, 1, 3, 7};

// What the other episodes show.
enum class Kind { kNone, kCompeting, kAgreeing, kOtherTask };
constexpr const char* kKindNames[] = {"none", "competing", "agreeing", "other task"};

// The episodes between, whose seeds no other episode has.
TrialGroup make_group(const MemoryFacts& facts, Lookahead& lookahead, std::uint64_t seed, int count,
                      Kind kind) {
  CounterfactualSampler chooser(lookahead, facts, seed);
  Trial trial{.draw = {seed, chooser.any()}};
  trial.question = lookahead.cue_end(trial.draw);
  RandomStream random(seed, 0, kPurposeProbeOthers);
  for (int i = 0; i < count; ++i) {
    EpisodeDraw other{random.next_u64()};
    if (kind == Kind::kAgreeing) other.pins = trial.draw.pins;
    if (kind == Kind::kCompeting) {
      const auto pins = chooser.other_answer(trial.draw.pins);
      if (!pins) trial.question = -1;
      if (pins) other.pins = *pins;
    }
    trial.others.push_back(std::move(other));
  }
  return {trial};
}

struct Point {
  int others = 0;
  Kind kind = Kind::kNone;
};

// The share of wrong answers that the last of the other episodes has got, too.
Json intrusions_of(const ConditionResults& results) {
  std::vector<bool> intrusions;
  for (const std::vector<TrialResult>& group : results) {
    const TrialResult& trial = group.front();
    if (trial.played == 0 || trial.answered == 0 || trial.correct != 0) continue;
    intrusions.push_back(trial.other_answered != 0 && trial.answer == trial.other_answer);
  }
  return rate_document(intrusions);
}

Json document_of(const ProbeTask& task, const std::vector<Point>& points,
                 const std::vector<ConditionResults>& results) {
  JsonList rows;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& point = points[i];
    const bool same_task = point.kind == Kind::kCompeting || point.kind == Kind::kAgreeing;
    rows.emplace_back(JsonTable{{"others", point.others},
                                {"kind", kKindNames[static_cast<std::size_t>(point.kind)]},
                                {"success", success_document(results[i])},
                                {"first_answer", first_answer_document(results[i])},
                                {"intrusions", same_task ? intrusions_of(results[i]) : Json()}});
  }
  return JsonTable{{"chance", task.info.chance()},
                   {"answer_chance", task.info.answer_chance()},
                   {"points", rows}};
}

}  // namespace

ProbePlan plan_interference(const ProbeTask& task, const RegistryEntry* other) {
  if (const std::string reason = task.no_counterfactuals(); !reason.empty())
    return skipped_plan(reason);
  std::vector<Point> points = {{0, Kind::kNone}};
  for (const int count : kOthers) {
    if (count == 0) continue;
    points.push_back({count, Kind::kCompeting});
    points.push_back({count, Kind::kAgreeing});
    if (other != nullptr) points.push_back({count, Kind::kOtherTask});
  }
  ProbePlan plan;
  for (const Point& point : points) {
    ProbeCondition condition{.entry = task.entry, .constants = task.constants};
    if (point.kind == Kind::kOtherTask) condition.other = other;
    condition.trials = [&facts = task.facts(), point](Lookahead& lookahead, std::uint64_t seed) {
      return make_group(facts, lookahead, seed, point.others, point.kind);
    };
    plan.conditions.push_back(std::move(condition));
  }
  plan.document = [task, points](const std::vector<ConditionResults>& results) {
    return document_of(task, points, results);
  };
  return plan;
}

}  // namespace engram
