/// @file
/// engram: the preset for training, with which plain learners with default hyperparameters learn.
/// The C++ API, a thin layer over engram_training_c.h; docs/learning.md has the equations.
///
///     #include <engram/engram_training.h>
///
///     engram::TrainingEnv env("RememberColor3-VLA-v0",
///                             {.num_envs = 64, .auto_reset = engram::AutoReset::kSameStep});
///     std::vector<float> actions = env.batch().make_actions();
///     for (env.reset(); true; env.step(actions)) {
///       choose(env.observation(), actions);
///       learn(env.reward(), env.batch().terminated());
///     }
#ifndef ENGRAM_ENGRAM_TRAINING_H
#define ENGRAM_ENGRAM_TRAINING_H

#include "engram/engram.h"
#include "engram/engram_training_c.h"

namespace engram {
inline namespace v0 {

struct TrainingOptions {
  // begin generated: fields (tools/surface, from api/surface.toml)
  /// Discount of the learner; more than 0, up to 1.
  double gamma = 0.99;
  /// An action of 1 is 0.3 of the arm's largest motion, 0.1 of its largest rotation, 0.5 of the
  /// gripper's; larger ones reach the limits.
  bool scale_actions = true;
  /// Weight of an episode's past actions in the next one; 0 (none) to less than 1.
  double smoothing = 0.0;
  /// Rows of states in fixed units from the TCP, rows of objects in a lasting order too.
  bool scale_observations = true;
  /// One more column where there are rows: the share of the horizon that is left.
  bool time_left = true;
  /// Weight of the dense reward in the potential whose differences are the reward, 0 or more; 0: no
  /// potential, the reward is the batch's own.
  double potential = 1.0;
  /// Weight of standing still in the potential, where the arm has to, 0 (none) or more.
  double still = 0.0;
  /// For each step that the first success leaves of the horizon, discounted, 0 (none) or more.
  double bonus = 0.1;
  // end generated
};

/// A batch with the preset for training. Movable; a moved-from one can only be destroyed.
class TrainingEnv {
 public:
  /// Makes the batch too, with episodes that end at success. Throws the errors of make(), and Error
  /// (kInvalidArgument) for an option outside its range.
  explicit TrainingEnv(const std::string& id, const EnvOptions& options = {},
                       const TrainingOptions& training = {})
      : TrainingEnv(VectorEnv(id, ending(options)), training) {}
  /// Takes a batch, of several tasks too, whose episodes end at success.
  explicit TrainingEnv(VectorEnv batch, const TrainingOptions& training = {})
      : batch_(std::move(batch)), handle_(make_handle(batch_, training)) {}
  TrainingEnv(TrainingEnv&&) = default;
  TrainingEnv& operator=(TrainingEnv&&) = delete;

  /// As VectorEnv::reset. The first call starts the episodes of all environments.
  void reset(const ResetRequest& request = {}) {
    detail::with_reset_request(request, batch_.num_envs(), [this](const engram_reset_request* c) {
      return engram_training_reset(handle(), c);
    });
  }
  /// One control step of all environments. actions: (N, action_dim), clipped to action_low() and
  /// action_high(). Throws Error as VectorEnv::step does.
  void step(std::span<const float> actions) {
    detail::check(engram_training_step(handle(), actions.data(), actions.size()));
  }

  /// Bounds of each action component (action_dim); infinite where there is none.
  std::span<const float> action_low() const {
    return view(engram_training_action_low(handle()), batch_.action_low().size());
  }
  std::span<const float> action_high() const {
    return view(engram_training_action_high(handle()), batch_.action_high().size());
  }
  /// Floats of an observation; 0 where the batch has no rows.
  int observation_dim() const { return engram_training_observation_dim(handle()); }
  /// (N, observation_dim) of the last reset or step.
  std::span<const float> observation() const {
    return view(engram_training_observation(handle()), rows_size());
  }
  /// (N, observation_dim) at the end of the episode that ended last in each environment
  /// (kSameStep only); batch().final_mask() tells where that was in this step.
  std::span<const float> final_observation() const {
    return view(engram_training_final_observation(handle()), rows_size());
  }
  /// (N) of this step.
  std::span<const float> reward() const {
    return view(engram_training_reward(handle()), batch_.reward().size());
  }

  /// The batch, whose outputs are the benchmark's own. Resets and steps are this object's.
  const VectorEnv& batch() const { return batch_; }
  /// For functions of engram_training_c.h; still owned by this object.
  engram_training* handle() const { return handle_.get(); }

 private:
  struct Close {
    void operator()(engram_training* training) const { engram_training_close(training); }
  };

  static EnvOptions ending(EnvOptions options) {
    if (!options.terminate_on_success) options.terminate_on_success = true;
    return options;
  }
  static engram_training* make_handle(const VectorEnv& batch, const TrainingOptions& options) {
    using detail::plain;
    engram_training_options c;
    engram_training_options_init(&c);
    // begin generated: copies
    c.gamma = plain(options.gamma);
    c.scale_actions = plain(options.scale_actions);
    c.smoothing = plain(options.smoothing);
    c.scale_observations = plain(options.scale_observations);
    c.time_left = plain(options.time_left);
    c.potential = plain(options.potential);
    c.still = plain(options.still);
    c.bonus = plain(options.bonus);
    // end generated
    engram_training* made = nullptr;
    detail::check(engram_training_make(batch.handle(), &c, &made));
    return made;
  }
  static std::span<const float> view(const float* values, std::size_t size) {
    return {values, values == nullptr ? 0 : size};
  }
  std::size_t rows_size() const {
    return static_cast<std::size_t>(batch_.num_envs()) *
           static_cast<std::size_t>(observation_dim());
  }

  VectorEnv batch_;
  std::unique_ptr<engram_training, Close> handle_;  // closed before the batch
};

}  // namespace v0
}  // namespace engram

#endif
