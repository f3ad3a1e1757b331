// Info "reward_dict": what the dense reward is made of. The original computes the reward after it
// exports the info, so the values are those of the step before; NaN where there are none.
//
// The reward of a family is one struct: what it depends on, and its terms. compute() works out the
// terms and returns the reward; list_terms() names them, each beside its value:
//   template <class Row>
//   void list_terms(Row& row) const {
//     row.term("tcp_to_obj_dist", "m", distance);
//   }
// reward_terms_of() reads the names, RewardDict the values.
#pragma once

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "core/task/task.h"

namespace engram::tasks {

// Reads the names of terms; values do not count.
class TermLister {
 public:
  void term(const char* name, const char* unit, double /*value*/) {
    terms_.push_back({name, 1, DType::kFloat32, unit, ""});
  }
  std::vector<Field> take() { return std::move(terms_); }

 private:
  std::vector<Field> terms_;
};

// Writes the values of terms, one behind the other.
class TermWriter {
 public:
  explicit TermWriter(float* out) : out_(out) {}
  void term(const char* /*name*/, const char* /*unit*/, double value) {
    *out_++ = static_cast<float>(value);
  }

 private:
  float* out_;
};

template <class Reward>
std::vector<Field> reward_terms_of(const Reward& reward) {
  TermLister lister;
  reward.list_terms(lister);
  return lister.take();
}

class RewardDict {
 public:
  void bind(const Bindings& bindings, std::size_t terms) {
    const int width = static_cast<int>(terms);
    elapsed_ = bindings.state->elapsed;
    shown_ = bindings.outputs->add_privileged<float>(
        "reward_dict", width, "",
        "reward terms of the step before; NaN where there are "
        "none");
    next_ = bindings.memory->add<float>("reward_dict", width);
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

  // Computes the reward of this step and notes its terms.
  template <class Reward>
  double compute(int env, Reward& reward) const {
    const double value = reward.compute();
    TermWriter writer(next_.row(env));
    reward.list_terms(writer);
    return value;
  }

  // Writes the rewards of this step; `measure` gives what that of an environment depends on.
  template <class Measure>
  void write(Range envs, FloatRows out, const Measure& measure) const {
    for (int env = envs.begin; env < envs.end; ++env) {
      auto reward = measure(env);
      *out.row(env) = static_cast<float>(compute(env, reward));
    }
  }

 private:
  Column<std::int32_t> elapsed_;
  Column<float> shown_;
  Column<float> next_;  // of this step; shown by the next evaluation
};

}  // namespace engram::tasks
