// Intervals of success rates, and tests of differences between two policies on the same episodes.
#pragma once

#include <optional>
#include <vector>

namespace engram {

struct Interval {
  double low = 0;
  double high = 1;
};

// Wilson's 95 % score interval of a rate that `episodes` independent episodes have shown.
Interval wilson_interval(double rate, double episodes);

// The number of independent episodes that are worth as much as `repeats` rounds of the same ones,
// one round after the other: all of them if repeats differ like other episodes, one round if they
// are all alike.
double effective_episodes(const std::vector<bool>& successes, int repeats);

// Episodes of two policies, A and B, by who succeeds.
struct PairCounts {
  int both = 0;
  int only_a = 0;
  int only_b = 0;
  int neither = 0;

  int total() const { return both + only_a + only_b + neither; }
};

// McNemar's exact test, two-sided: how probable so uneven counts of one-sided successes are for two
// equal policies.
double mcnemar_p_value(int only_a, int only_b);
// Sign-flip test of numbers beyond 0 and 1: A's successes minus B's in each independent episode, of
// which all signs are equally probable for two equal policies.
double sign_flip_p_value(const std::vector<int>& differences);

// 95 % interval of A's rate minus B's: Newcombe's hybrid score interval for paired data (1998,
// method 10).
Interval paired_interval(const PairCounts& counts);
// Interval of the mean of independent differences, by the normal distribution, within [-bound,
// bound].
Interval mean_interval(const std::vector<int>& differences, double bound);

// The smallest difference of two rates that McNemar's test can call significant (p < 0.05) with so
// many pairs: all that differ do so in one direction. Nothing if there is none.
std::optional<double> smallest_difference(int pairs);
// The true difference that it finds in 80 % of all comparisons with `pairs` pairs, of which that
// share differs (Connor 1987). Nothing if no true difference is that large.
std::optional<double> detectable_difference(int pairs, double differing);

}  // namespace engram
