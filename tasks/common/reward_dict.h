// Info "reward_dict": what the dense reward is made of. The original computes the reward after it
// exports the info, so the values are those of the step before; NaN where there are none.
//
// A family lists its terms once, name beside value:
//   template <class Row>
//   void list_terms(Row& row, const Inputs& in, const Terms& terms) {
//     row.term("tcp_to_obj_dist", "m", in.distance);
//   }
// reward_terms_of() reads the names, RewardDict::note() the values.
#pragma once

#include <algorithm>
#include <concepts>
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

// The terms that `list`, a callable with a row, names.
template <class List>
std::vector<Field> reward_terms_of(const List& list) {
  TermLister lister;
  list(lister);
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

  // Notes the terms of this step; `list` is the one that TaskInfo::reward_terms came from.
  template <class List>
  requires std::invocable<const List&, TermWriter&>
  void note(int env, const List& list) const {
    TermWriter writer(next_.row(env));
    list(writer);
  }

 private:
  Column<std::int32_t> elapsed_;
  Column<float> shown_;
  Column<float> next_;  // of this step; shown by the next evaluation
};

}  // namespace engram::tasks
