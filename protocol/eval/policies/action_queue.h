// The actions of one episode on their way from its policy to its robot.
#pragma once

#include <deque>
#include <span>
#include <vector>

namespace engram {

class ActionQueue {
 public:
  // latency: control steps from a question to the first action of its answer.
  explicit ActionQueue(int latency = 0) : latency_(latency) {}

  // True if the policy is to be asked now: nothing is left, and nothing on its way.
  bool empty() const { return actions_.empty(); }
  // The answer to a question of this moment.
  void answer(std::span<const float> actions);
  // Writes the action of this step. While an answer is on its way that is the last one; returns
  // false if there has been none.
  bool next(std::span<float> action);

 private:
  int latency_;
  int waiting_ = 0;  // steps before the first of `actions_`
  std::deque<float> actions_;
  std::vector<float> last_;
};

}  // namespace engram
