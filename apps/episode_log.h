// Counts of a batch of environments: steps, finished episodes and their results.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "protocol/make/make.h"

namespace engram::apps {

class EpisodeLog {
 public:
  // episodes: how many to count; 0: all. Every environment contributes the same number of its first
  // ones, give or take one, so that quick episodes do not outnumber slow ones.
  EpisodeLog(const Batch& batch, int episodes);

  // Takes in the outputs of the last step; to be called after every step.
  void update(const Batch& batch);

  // True if all requested episodes are counted, or no environment is active any more.
  bool complete() const { return moving_ == 0 || (wanted_ > 0 && episodes_ == wanted_); }
  // The share that is counted of the episodes asked for; 0 if no number was given.
  double fraction() const {
    return wanted_ > 0 ? static_cast<double>(episodes_) / static_cast<double>(wanted_) : 0;
  }

  // Steps that simulated something: not those that only reset or left an environment alone.
  std::int64_t env_steps() const { return env_steps_; }
  std::int64_t episodes() const { return episodes_; }
  // Means over the counted episodes; not a number if there are none.
  double success_rate() const { return mean(static_cast<double>(successes_)); }
  double mean_return() const { return mean(return_sum_); }

 private:
  void finish_episode(const Batch& batch, int index);
  double mean(double sum) const {
    return episodes_ > 0 ? sum / static_cast<double>(episodes_)
                         : std::numeric_limits<double>::quiet_NaN();
  }

  std::int64_t wanted_;
  std::vector<std::uint8_t> finished_;  // the episode has ended, the next one has not begun
  std::vector<std::int32_t> quota_;     // episodes of this environment that are yet to be counted
  int moving_;                          // environments that can still simulate something
  std::int64_t env_steps_ = 0;
  std::int64_t episodes_ = 0;
  std::int64_t successes_ = 0;
  double return_sum_ = 0;
};

}  // namespace engram::apps
