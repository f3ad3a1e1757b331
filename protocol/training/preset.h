// The preset for training: a batch with which plain learners with default numbers learn. Actions
// and observations in other scales, the time that is left, and a reward of its own;
// docs/learning.md has the reasons and the equations.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/batch/batch.h"
#include "protocol/training/numbers.h"
#include "protocol/training/scaled_rows.h"
#include "protocol/training/shaped_reward.h"

namespace engram::training {

// Resets and steps a batch on its threads. The batch's own outputs stay what they are. Between two
// calls nobody else resets, steps or restores it.
class Preset {
 public:
  // The batch outlives this object. Throws Error for an option out of its range, and for a batch
  // whose episodes do not end at success.
  Preset(Batch& batch, const Options& options);

  // Starts new episodes; the first call those of all environments. Throws the errors of
  // Batch::reset.
  void reset(const ResetRequest& request = {});
  // One control step. actions: (num_envs, action_dim), in action_space(). Throws the errors of
  // Batch::step, and before the first reset.
  void step(std::span<const float> actions);

  const ActionSpace& action_space() const { return action_space_; }
  // Floats of an observation; 0 where the batch has no rows.
  int observation_dim() const { return dim_; }
  std::span<const float> observation() const { return observation_; }  // (num_envs, dim)
  // (num_envs, dim): at the end of the episode that ended last in each environment; empty unless
  // auto-reset is same-step. The batch's final_mask tells of which step it is.
  std::span<const float> final_observation() const { return final_observation_; }
  std::span<const float> reward() const { return reward_; }  // (num_envs)

 private:
  // Arrays of the batch, of now or of the ends of episodes.
  struct Source {
    Column<const float> rows;
    Column<const float> reward_terms;
    const float* reward = nullptr;
    const std::uint8_t* success = nullptr;
    const std::uint8_t* success_once = nullptr;
    const std::int32_t* elapsed = nullptr;
  };

  static Source source_of(const std::vector<OutputArray>& arrays);
  void set_action_space();
  void set_rows();
  void scale();
  // Rewards, ends and observations of environments, after a step.
  void finish(const BatchData& part, Range envs);
  void finish(int env);
  void begin(int env);
  // The row of an environment in rows, (num_envs, dim). begins: it is an episode's first.
  void write_row(const Source& source, int env, bool begins, float* rows);

  Batch& batch_;
  Options options_;
  AutoReset auto_reset_;
  ShapedReward shaping_;
  std::optional<StateRows> states_;
  std::optional<ObjectRows> objects_;
  Source now_;
  Source last_;  // of ended episodes; same-step only
  const std::uint8_t* terminated_ = nullptr;
  const std::uint8_t* truncated_ = nullptr;
  std::vector<std::int32_t> horizons_;  // (num_envs)
  ActionSpace action_space_;
  std::vector<float> scales_;  // (action_dim)
  int dim_ = 0;
  bool started_ = false;
  std::vector<float> given_;     // (num_envs, action_dim), as the next three
  std::vector<float> smoothed_;  // of this step
  std::vector<float> past_;      // of the step before
  std::vector<float> scaled_;
  std::vector<std::uint8_t> over_;  // (num_envs): ended, and not yet begun again
  std::vector<float> observation_;
  std::vector<float> final_observation_;
  std::vector<float> reward_;
};

}  // namespace engram::training
