// The episode of `engram record` and its policy.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/interruption.h"
#include "apps/policy_command.h"
#include "protocol/eval/policies/scripted_actor.h"
#include "protocol/make/make.h"

namespace engram::apps {

struct EpisodeOptions {
  std::string id;
  MakeOptions env;  // of the batch that is rendered
  int steps = 0;    // at most; 0: to the end
  Policy policy = Policy::kOracle;
  PolicyCommand command;       // takes the place of `policy` if it is given
  std::optional<ObsMode> obs;  // observation of the command; images by default
  RunOptions run;

  // The environment as the command sees it.
  MakeOptions observed() const;
};

// A command as the policy of one episode. It observes a batch of its own, which takes the same
// steps: its images are those of an evaluation, whatever the size and quality of the recording.
class CommandPolicy {
 public:
  // stopped: set when the command's answers are no longer needed.
  CommandPolicy(const EpisodeOptions& options, const std::atomic<bool>& stopped);

  // The next action, or none so far. The batch of the command is stepped with it.
  void act(std::span<float> actions, std::span<std::uint8_t> commanded);
  // Throws Error if the policy has sent more than it was asked for.
  void check_no_pending_reply() { process_.check_no_pending_reply(); }
  int longest_chunk() const { return actor_->longest_chunk(); }

 private:
  std::atomic<std::uint64_t> env_steps_ = 0;
  WorkContext context_;
  std::unique_ptr<Batch> batch_;
  PolicyProcess process_;
  std::unique_ptr<EpisodeActor> actor_;
};

class RecordedEpisode {
 public:
  // Steps end with an Error once there is an interruption.
  RecordedEpisode(const EpisodeOptions& options, const Interruption& interruption);

  Batch& batch() { return *batch_; }
  int steps() const { return batch_->state().elapsed[0]; }
  int max_steps() const { return max_steps_; }
  bool over() const;
  bool success_once() const { return *batch_->output("success_once").row(0) != std::byte{0}; }
  // Actions of the longest chunk that the policy has answered with.
  int chunk_size() const { return command_policy_ ? command_policy_->longest_chunk() : 1; }

  void step();
  // Back to the beginning. Steps that have been taken are taken again without asking the policy,
  // which might answer something else.
  void rewind();

 private:
  struct Action {
    std::vector<float> values;
    std::array<std::uint8_t, 1> commanded{};
  };

  const Interruption& interruption_;
  int max_steps_;
  std::unique_ptr<Batch> batch_;
  std::optional<CommandPolicy> command_policy_;
  std::optional<ScriptedActor> own_policy_;
  std::vector<Action> actions_;  // of all steps so far
};

}  // namespace engram::apps
