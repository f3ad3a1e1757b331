#include "protocol/make/episodes.h"

namespace engram {

Batch& EpisodeBatch::of(std::string_view id, int count, int num_envs, const MakeOptions& options) {
  // A batch that has been played with may be larger than needed: the rest of it stands still.
  if (batch_ == nullptr || id_ != id || policy_seed_ != options.policy_seed ||
      batch_->num_envs() < std::min(count, num_envs)) {
    batch_.reset();
    MakeOptions own = options;
    own.auto_reset = AutoReset::kOff;
    own.threads = 1;
    own.num_envs = std::min(count, num_envs);
    batch_ = make(id, own);
    id_ = id;
    policy_seed_ = options.policy_seed;
  }
  return *batch_;
}

}  // namespace engram
