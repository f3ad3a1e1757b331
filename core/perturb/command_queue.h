// Commands on their way to the robot, late and noisy where perturbations say so.
#pragma once

#include <cstdint>

#include "core/base/column.h"
#include "core/perturb/perturbation.h"
#include "core/sim/controller.h"

namespace engram {

class CommandQueue {
 public:
  // Adds columns where they are needed.
  void bind(ColumnStore& memory, const Perturbations& perturbations, const ActionSpace& space);

  // False: commands are followed as they are given.
  bool is_used() const { return used_; }
  // True: environments differ in whether they have a command to follow.
  bool delays() const { return delays_; }

  // The command that an environment follows in its step `elapsed`; null: none. given: null for
  // none. noise: of this step.
  const float* next(const Perturbations& perturbations, int env, int elapsed, const float* given,
                    RandomStream noise) const;
  // Whether the last call of next() returned one.
  bool follows(int env) const { return follows_[env] != 0; }

 private:
  static constexpr int kPlaces = Perturbations::kMaxActionDelay + 1;

  const float* delayed(int env, int elapsed, int delay, const float* given) const;
  void add_noise(float* command, double share, RandomStream noise) const;

  bool used_ = false;
  bool delays_ = false;
  bool normalized_ = true;
  int dim_ = 0;
  Column<float> command_;          // the one that is followed
  Column<float> given_;            // the last ones, by the step modulo kPlaces
  Column<std::uint8_t> is_given_;  // 0: there was none
  Column<std::uint8_t> follows_;
};

}  // namespace engram
