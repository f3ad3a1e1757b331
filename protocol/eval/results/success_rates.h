// Success rates of task documents and of groups of them, with intervals.
#pragma once

#include <map>
#include <string>

#include "protocol/eval/results/statistics.h"
#include "protocol/io/json.h"

namespace engram {

struct SuccessRate {
  double rate = 0;
  Interval interval;  // 95 %, Wilson's
  int tasks = 0;
  int episodes = 0;  // all rounds together
};

SuccessRate success_rate(const Json& task);
// The mean over tasks. The interval takes all episodes for draws from one population, which is
// wider than needed where tasks differ.
SuccessRate mean_success_rate(const JsonList& tasks);
// The mean over the tasks that have the same text under a key, by that text.
std::map<std::string, SuccessRate> success_rates_by(const char* key, const JsonList& tasks);

// Rounds of the episodes of a task; 1 in documents that do not say.
int repeats_of(const Json& task);
// [low, high].
Json to_document(const Interval& interval);
// "0.12-0.34", for people.
std::string to_text(const Interval& interval);

}  // namespace engram
