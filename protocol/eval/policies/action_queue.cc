#include "protocol/eval/policies/action_queue.h"

#include <algorithm>

namespace engram {

void ActionQueue::answer(std::span<const float> actions) {
  actions_.assign(actions.begin(), actions.end());
  waiting_ = latency_;
}

bool ActionQueue::next(std::span<float> action) {
  if (waiting_ > 0) {
    --waiting_;
    std::ranges::copy(last_, action.begin());
    return !last_.empty();
  }
  const auto dim = static_cast<std::ptrdiff_t>(action.size());
  std::copy_n(actions_.begin(), dim, action.begin());
  actions_.erase(actions_.begin(), actions_.begin() + dim);
  if (latency_ > 0) last_.assign(action.begin(), action.end());
  return true;
}

}  // namespace engram
