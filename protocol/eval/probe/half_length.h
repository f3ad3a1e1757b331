// The length of a delay at which half of what is above chance is left.
#pragma once

#include <optional>
#include <vector>

#include "protocol/io/json.h"

namespace engram {

// Answers of the same episodes after one delay.
struct DelayedAnswers {
  int delay = 0;  // control steps
  std::vector<bool> right;
  std::vector<bool> played = {};  // empty: all; the others do not count
};

// Between two delays the rate is linear over the logarithm of 1 + delay. Nothing if the first rate
// is not above chance, or no later one is as low as half way to it.
std::optional<double> half_length(const std::vector<DelayedAnswers>& answers, double chance);

// {steps, interval}: with the 95 % interval of a bootstrap over episodes; null for what lies beyond
// the longest delay. Null if the first rate is not above chance.
Json half_length_document(const std::vector<DelayedAnswers>& answers, double chance);

}  // namespace engram
