#include "protocol/make/episodes.h"

namespace engram {

Batch& EpisodeBatch::of(std::string_view id, int count, int num_envs, const MakeOptions& options) {
  // A batch that has been played with may be larger than needed: the rest of it stands still.
  if (env_ == nullptr || id_ != id || policy_seed_ != options.policy_seed ||
      env_->num_envs() < std::min(count, num_envs)) {
    env_.reset();
    MakeOptions own = options;
    own.auto_reset = AutoReset::kOff;
    own.threads = 1;
    own.num_envs = std::min(count, num_envs);
    env_ = make(id, own);
    id_ = id;
    policy_seed_ = options.policy_seed;
  }
  return *env_;
}

}  // namespace engram
