// Policies of ShellGameTouch from objects, with a memory of one place.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <vector>

#include "protocol/eval/policies/external_policy.h"

namespace engram::test {

// Touches the cup, counted from one side, under which it has last seen a ball since `first`.
class RememberingPolicy final : public ExternalPolicy {
 public:
  // remembers: false, the cup is forgotten at every step.
  explicit RememberingPolicy(bool remembers) : remembers_(remembers) {}

  void act(const PolicyRequest& request, PolicyReply& reply) override {
    for (int row = 0; row < request.count; ++row) {
      const auto i = static_cast<std::size_t>(row);
      if (request.first[i] != 0 || !remembers_) cups_.erase(request.slots[i]);
      const float* const seen =
          request.state.data() + i * static_cast<std::size_t>(request.state_dim);
      // Other tasks, whose episodes come between, have other numbers of objects.
      const int objects = (request.state_dim - kFirstObject) / kObjectWidth;
      const std::vector<Place> cups = look(seen, objects, request.slots[i]);
      const auto found = cups_.find(request.slots[i]);
      const std::size_t cup = found == cups_.end() ? 1 : found->second;  // the middle one
      std::vector<float> action(7);
      if (cup < cups.size()) {
        const float* const tcp = seen + kTcp;
        const float x = cups[cup][0] - tcp[0];
        const float y = cups[cup][1] - tcp[1];
        action[0] = std::clamp(kGain * x, -1.0F, 1.0F);
        action[1] = std::clamp(kGain * y, -1.0F, 1.0F);
        // Passes above the others.
        const bool above = x * x + y * y < kAbove * kAbove;
        if (above) action[2] = std::clamp(kGain * (kHeight - tcp[2]), -1.0F, 1.0F);
      }
      const std::int64_t shape[] = {7};
      reply.set(row, action, shape);
    }
  }

 private:
  using Place = std::array<float, 2>;

  // Layout of the observation's row.
  static constexpr int kTcp = 18;
  static constexpr int kFirstObject = 25;
  static constexpr int kObjectWidth = 42;
  static constexpr int kPosition = 1;
  static constexpr int kBall = 34;  // of the kinds
  static constexpr int kCup = 35;
  static constexpr float kGain = 14;
  static constexpr float kHeight = 0.16F;
  static constexpr float kAbove = 0.04F;   // m
  static constexpr float kHalfWay = 0.2F;  // m, from the middle cup to the others

  // Returns the cups from one side to the other.
  std::vector<Place> look(const float* row, int objects, std::int32_t env) {
    std::vector<Place> cups;
    std::vector<Place> balls;
    for (int object = 0; object < objects; ++object) {
      const float* const token = row + kFirstObject + object * kObjectWidth;
      const Place place = {token[kPosition], token[kPosition + 1]};
      if (token[kBall] > 0.5F) balls.push_back(place);
      if (token[kCup] > 0.5F) cups.push_back(place);
    }
    std::ranges::sort(cups, {}, [](const Place& place) { return place[1]; });
    for (const Place& ball : balls) {
      cups_[env] = ball[1] < -kHalfWay ? 0 : ball[1] < kHalfWay ? 1 : 2;
    }
    return cups;
  }

  bool remembers_;
  std::map<std::int32_t, std::size_t> cups_;
};

}  // namespace engram::test
