// Rules and rewards of the RL tasks of BunchOfColors, SeqOfColors and ChainOfColors, against a
// second implementation.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "tests/env_helpers.h"
#include "tests/tasks/colors/touch_ids.h"
#include "tests/tasks/spectator.h"

namespace engram {
namespace {

using test::make_running, test::Point, test::Spectator, test::touch_colors::is_chain,
    test::touch_colors::kFamilies, test::touch_colors::start_of;

// The rules and the dense reward, programmed again from their description.
class Reference {
 public:
  Reference(const std::string& id, int length)
      : chain_(is_chain(id)), start_(start_of(id, length)), order_(length, -1) {}

  double reward(const Spectator& scene) {
    const int length = static_cast<int>(order_.size());
    std::vector<int> cue;
    for (int i = 0; i < length; ++i) cue.push_back(scene.info_int("oracle_info", i));
    const bool acting = scene.elapsed() >= start_;
    if (acting && scene.still()) note_touches(scene);
    const int next = next_target(cue);
    const double g = next < 0 ? 0 : (touch_point(scene, next) - scene.tcp()).norm();
    double speed = 0;
    for (int i = 0; i < 7; ++i) speed += std::pow(scene.state().qvel.row(scene.index())[i], 2);
    int right = 0;
    int wrong = 0;
    for (int i = 0; i < length && chain_; ++i) {
      (order_[static_cast<std::size_t>(i)] == cue[static_cast<std::size_t>(i)] ? right : wrong) +=
          order_[static_cast<std::size_t>(i)] < 0 ? 0 : 1;
    }
    for (const int color : chain_ ? std::set<int>{} : touched_) {
      ++(std::count(cue.begin(), cue.end(), color) > 0 ? right : wrong);
    }
    success = acting && scene.still() && touched_ == std::set<int>(cue.begin(), cue.end()) &&
              (!chain_ || order_ == cue);
    if (success) return 100;
    return acting ? 1 - std::tanh(10 * g) + 0.5 * (1 - std::tanh(5 * std::sqrt(speed))) +
                        90.0 * right / length - 10.0 * wrong
                  : 0;
  }

  bool success = false;
  int touches() const { return static_cast<int>(touched_.size()); }

 private:
  static Point touch_point(const Spectator& scene, int color) {
    return scene.pos(color) + Point(0, 0, 0.025);
  }
  void note_touches(const Spectator& scene) {
    for (int color = 0; color < 9; ++color) {
      if ((touch_point(scene, color) - scene.tcp()).norm() >= 0.02) continue;
      if (!touched_.insert(color).second) continue;
      auto free = std::find(order_.begin(), order_.end(), -1);
      *(free == order_.end() ? order_.begin() : free) = color;
    }
  }
  int next_target(const std::vector<int>& cue) const {
    for (std::size_t i = 0; i < cue.size() && chain_; ++i) {
      if (order_[i] != cue[i]) return cue[i];
    }
    if (chain_) return cue.back();
    int lowest = -1;
    for (const int color : cue) {
      if (!touched_.contains(color) && (lowest < 0 || color < lowest)) lowest = color;
    }
    return lowest;
  }

  bool chain_;
  int start_;
  std::vector<int> order_;
  std::set<int> touched_;
};

TEST_CASE("RL colours: rewards are those of the formula, whatever the policy",
          "[color_recall][rl]") {
  constexpr int kEnvs = 5;
  for (const char* family : kFamilies) {
    int steps = 0;
    int successes = 0;
    int mistakes = 0;
    for (const int length : {3, 5, 7}) {
      for (const Policy policy : {Policy::kOracle, Policy::kBlind, Policy::kRandom}) {
        const std::string id = family + std::to_string(length) + "-v0";
        INFO(id << ", " << name_of(policy));
        BatchOptions options{.num_envs = kEnvs};
        options.seed = 90'000;
        options.reward_mode = RewardMode::kDense;
        options.terminate_on_success = false;
        options.auto_reset = AutoReset::kOff;
        const auto batch = make_running(id, options);
        std::vector<Reference> references(kEnvs, Reference(id, length));
        while (batch->state().finished[0] == 0) {
          test::step(*batch, policy);
          for (int i = 0; i < kEnvs; ++i) {
            Reference& reference = references[static_cast<std::size_t>(i)];
            const double expected = reference.reward(Spectator(*batch, i));
            const auto index = static_cast<std::size_t>(i);
            if (std::abs(static_cast<double>(batch->outputs().reward[index]) - expected) > 2e-5) {
              FAIL("environment " << i << ", step " << batch->state().elapsed[i] << ": "
                                  << batch->outputs().reward[index] << " instead of " << expected);
            }
            REQUIRE((batch->outputs().success[index] != 0) == reference.success);
            ++steps;
          }
        }
        for (const Reference& reference : references) {
          successes += reference.success ? 1 : 0;
          mistakes += policy == Policy::kBlind && reference.touches() > 0 && !reference.success;
        }
      }
    }
    CHECK(steps >= 5000);
    CHECK(successes >= 12);
    CHECK(mistakes >= 5);
  }
}

}  // namespace
}  // namespace engram
