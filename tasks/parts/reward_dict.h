// Info "reward_dict": what the dense reward is made of. Upstream computes the reward after it
// exports the info, so the values are those of the step before; NaN where there are none.
#pragma once

#include <algorithm>
#include <array>
#include <limits>

#include "core/task.h"

namespace engram::tasks {

class RewardDict {
 public:
  void bind(const Bindings& bindings, int terms) {
    elapsed_ = bindings.state->elapsed;
    shown_ = bindings.outputs->add<float>("reward_dict", terms, "",
                                          "reward terms of the step before; NaN where there are "
                                          "none");
    next_ = bindings.memory->add<float>("reward_dict", terms);
  }

  // Shows the terms of the step before; once per evaluation.
  void publish(int env) const {
    constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
    if (elapsed_[env] <= 1) {
      std::fill_n(shown_.row(env), shown_.width(), kNone);
    } else {
      std::copy_n(next_.row(env), next_.width(), shown_.row(env));
    }
    std::fill_n(next_.row(env), next_.width(), kNone);
  }

  // Notes the terms of this step, in the order of TaskInfo::reward_terms.
  template <std::size_t Terms>
  void note(int env, const std::array<double, Terms>& terms) const {
    std::transform(terms.begin(), terms.end(), next_.row(env),
                   [](double value) { return static_cast<float>(value); });
  }

 private:
  Column<std::int32_t> elapsed_;
  Column<float> shown_;
  Column<float> next_;  // of this step; shown by the next evaluation
};

}  // namespace engram::tasks
