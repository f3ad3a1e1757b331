// Policies of ShellGameTouch from objects, with a memory of one place.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <vector>

#include "protocol/evaluation/external_policy.h"

namespace engram::test {

// Moves the tool over the place where it has last seen a ball, in the slot's life since `first`.
class RememberingPolicy final : public ExternalPolicy {
 public:
  // remembers: false, the place is forgotten at every step.
  explicit RememberingPolicy(bool remembers) : remembers_(remembers) {}

  void act(const PolicyRequest& request, PolicyReply& reply) override {
    for (int row = 0; row < request.count; ++row) {
      const auto i = static_cast<std::size_t>(row);
      if (request.first[i] != 0 || !remembers_) places_.erase(request.slots[i]);
      const float* const seen =
          request.state.data() + i * static_cast<std::size_t>(request.state_dim);
      look(seen, request.slots[i]);
      const auto place = places_.find(request.slots[i]);
      // Without a memory: the middle cup.
      const std::array<float, 2> goal =
          place == places_.end() ? std::array<float, 2>{0, 0} : place->second;
      std::vector<float> action(7);
      const float* const tcp = seen + kTcp;
      action[0] = std::clamp(kGain * (goal[0] - tcp[0]), -1.0F, 1.0F);
      action[1] = std::clamp(kGain * (goal[1] - tcp[1]), -1.0F, 1.0F);
      action[2] = std::clamp(kGain * (kHeight - tcp[2]), -1.0F, 1.0F);
      const std::int64_t shape[] = {7};
      reply.set(row, action, shape);
    }
  }

 private:
  // Layout of the observation's row.
  static constexpr int kTcp = 18;
  static constexpr int kFirstObject = 25;
  static constexpr int kObjectWidth = 42;
  static constexpr int kObjects = 4;
  static constexpr int kPosition = 1;
  static constexpr int kBall = 34;  // of the kinds
  static constexpr float kGain = 14;
  static constexpr float kHeight = 0.16F;

  void look(const float* row, std::int32_t slot) {
    for (int object = 0; object < kObjects; ++object) {
      const float* const token = row + kFirstObject + object * kObjectWidth;
      if (token[0] > 0.5F && token[kBall] > 0.5F) {
        places_[slot] = {token[kPosition], token[kPosition + 1]};
      }
    }
  }

  bool remembers_;
  std::map<std::int32_t, std::array<float, 2>> places_;
};

}  // namespace engram::test
