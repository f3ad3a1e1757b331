#include "core/perturb/command_queue.h"

#include <algorithm>

namespace engram {

void CommandQueue::bind(ColumnStore& memory, const Perturbations& perturbations,
                        const ActionSpace& space) {
  delays_ = perturbations.has(PerturbationAxis::kActionDelay);
  used_ = delays_ || perturbations.has(PerturbationAxis::kActionNoise);
  if (!used_) return;
  normalized_ = space.normalized;
  dim_ = space.dim();
  command_ = memory.add<float>("perturbed_command", dim_);
  if (!delays_) return;
  given_ = memory.add<float>("given_commands", kPlaces * dim_);
  is_given_ = memory.add<std::uint8_t>("is_given", kPlaces);
  follows_ = memory.add<std::uint8_t>("follows_command");
}

const float* CommandQueue::next(const Perturbations& perturbations, int env, int elapsed,
                                const float* given, RandomStream noise) const {
  if (delays_) given = delayed(env, elapsed, perturbations.action_delay(env), given);
  if (given == nullptr) return nullptr;
  float* command = command_.row(env);
  std::copy_n(given, dim_, command);
  add_noise(command, perturbations.action_noise(env), noise);
  return command;
}

const float* CommandQueue::delayed(int env, int elapsed, int delay, const float* given) const {
  const auto place = [](int step) { return step % kPlaces; };
  is_given_.row(env)[place(elapsed)] = given != nullptr ? 1 : 0;
  if (given != nullptr) std::copy_n(given, dim_, given_.row(env) + dim_ * place(elapsed));
  const bool follows = elapsed >= delay && is_given_.row(env)[place(elapsed - delay)] != 0;
  follows_[env] = follows ? 1 : 0;
  return follows ? given_.row(env) + dim_ * place(elapsed - delay) : nullptr;
}

// The gripper's command, which comes last, has none.
void CommandQueue::add_noise(float* command, double share, RandomStream noise) const {
  constexpr double kOfNormalized = 0.2;
  constexpr double kOfOthers = 0.01;  // rad or m
  if (!(share > 0)) return;
  const double deviation = share * (normalized_ ? kOfNormalized : kOfOthers);
  for (int i = 0; i + 1 < dim_; ++i) {
    command[i] += static_cast<float>(deviation * noise.normal());
  }
}

}  // namespace engram
