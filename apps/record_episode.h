// The episode that `engram record` shows, and who plays it.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/interruption.h"
#include "apps/policy_command.h"
#include "protocol/batch/make.h"

namespace engram::apps {

struct EpisodeOptions {
  std::string id;
  MakeOptions env;  // of the batch that is drawn for people
  int steps = 0;    // at most; 0: to the end
  Policy policy = Policy::kOracle;
  PolicyCommand command;       // takes the place of `policy` if it is given
  std::optional<ObsMode> obs;  // what the command sees; pictures by default

  // The environment as the command sees it.
  MakeOptions observed() const;
};

// A command that plays one episode. It sees a batch of its own, which takes the same steps: its
// pictures are those of an evaluation, however large and smooth those for people are.
class OutsidePlayer {
 public:
  // stopped: set when the command's answers are no longer needed.
  OutsidePlayer(const EpisodeOptions& options, const std::atomic<bool>& stopped);

  // The next action, which is taken at once.
  void act(std::span<float> actions);
  // Throws Error if the policy has said more than it was asked for.
  void settle() { process_.settle(); }
  int longest_chunk() const { return queue_.longest_chunk(); }

 private:
  std::atomic<std::uint64_t> env_steps_ = 0;
  WorkContext context_;
  std::unique_ptr<Batch> env_;
  PolicyProcess process_;
  ChunkedPolicy queue_;
};

class Episode {
 public:
  // Steps end with an Error once there is an interruption.
  Episode(const EpisodeOptions& options, const Interruption& interruption);

  Batch& env() { return *env_; }
  int steps() const { return env_->state().elapsed[0]; }
  int max_steps() const { return max_steps_; }
  bool over() const;
  bool success_once() const { return *env_->output("success_once").row(0) != std::byte{0}; }
  // Actions of the longest chunk that the policy has answered with.
  int chunk_size() const { return outside_ ? outside_->longest_chunk() : 1; }

  void step();
  // Back to the beginning. Steps that have been taken are taken again without asking the policy,
  // which might answer something else.
  void rewind();

 private:
  const Interruption& interruption_;
  Policy policy_;
  int max_steps_;
  std::unique_ptr<Batch> env_;
  std::optional<OutsidePlayer> outside_;
  std::vector<std::vector<float>> actions_;  // of all steps so far
};

}  // namespace engram::apps
