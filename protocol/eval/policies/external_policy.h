// External policies: they get the observations that the benchmark allows and answer with chunks of
// actions.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/eval/policies/action_queue.h"
#include "protocol/eval/policies/episode_actor.h"
#include "protocol/make/make.h"
#include "protocol/parallel/work_item.h"

namespace engram {

// Episodes that need actions, one row each in every array.
struct PolicyRequest {
  std::string_view env_id;
  int count = 0;
  // Slots of the episodes in the batch: constant during an episode, then reused. Below max_slots.
  std::span<const std::int32_t> slots;
  std::span<const std::int32_t> episodes;  // 0 to n_episodes - 1; for messages, not for policies
  std::span<const std::int32_t> numbers;   // by which policies know the episodes
  std::span<const std::uint64_t> seeds;    // of the episodes, if requests name them
  std::span<const std::int32_t> steps;     // control steps taken so far
  std::span<const std::uint8_t> first;     // 1: the first request of this episode
  std::span<const std::string> instructions;
  std::span<const float> proprio;     // (count, proprio_dim)
  std::span<const std::uint8_t> rgb;  // (count, height, width, 6); empty unless asked for
  std::span<const float> state;       // (count, state_dim); empty unless asked for
  int height = 0;
  int width = 0;
  int state_dim = 0;
  int proprio_dim = 0;
  int max_slots = 0;
  std::uint64_t policy_seed = 0;  // of the policy's own random numbers, the same in all rows
  // A policy that waits for something must give up when context->stopped().
  const WorkContext* context = nullptr;
};

// Takes the answer to a request, one chunk per row.
class PolicyReply {
 public:
  PolicyReply(int count, int action_dim);

  // Actions of one row, of shape (action_dim), (K, action_dim) or (1, K, action_dim), K >= 1.
  // Throws Error for other shapes, an unknown row or values that are not finite.
  void set(int row, std::span<const float> actions, std::span<const std::int64_t> shape);

  int action_dim() const { return action_dim_; }
  // (K, action_dim) of one row. Throws Error if it has not been set.
  std::span<const float> chunk(int row) const;

 private:
  int action_dim_;
  std::vector<std::vector<float>> chunks_;
};

struct ChoiceQuestion;  // protocol/eval/policies/choice_question.h
class ChoiceAnswer;

// Called by one thread at a time.
class ExternalPolicy {
 public:
  virtual ~ExternalPolicy() = default;
  virtual void act(const PolicyRequest& request, PolicyReply& reply) = 0;
  // Names an answer, for policies that are asked for answers instead of actions.
  virtual void choose(const ChoiceQuestion& question, ChoiceAnswer& answer);
  // Called when an item of work is done. Throws Error if the policy has sent more than it was asked
  // for: then some of its answers may belong to other requests.
  virtual void check_no_pending_reply() {}
};

// The label of an episode. tell: with its own number; otherwise with an opaque one, made with key.
EpisodeLabel label_episode(int episode, std::string_view env_id, std::uint64_t seed,
                           const std::string& key, bool tell);

struct ChunkedPolicyOptions {
  bool tell_seeds = false;        // requests have the episodes' seeds
  std::uint64_t policy_seed = 0;  // in all requests
  int latency = 0;                // control steps from a request to the first action of its answer
};

// Runs a batch with an external policy: a queue of actions per episode, filled by a chunk when it
// is empty and dropped at the end of the episode.
class ChunkedPolicy final : public EpisodeActor {
 public:
  ChunkedPolicy(const Batch& batch, ExternalPolicy& policy, const WorkContext& context,
                const ChunkedPolicyOptions& options);

  void start(int env, const EpisodeLabel& label) override;
  void replace_scene(int env, const EpisodeLabel& label) override;
  void finish(int env) override;
  void act(std::span<float> actions, std::span<std::uint8_t> commanded) override;
  const EpisodeDigests& digests(int env) const override;
  int longest_chunk() const override { return longest_chunk_; }

 private:
  struct EpisodeState {
    EpisodeLabel label;
    bool first = false;
    ActionQueue queue;
    EpisodeDigests digests;
  };

  // Rows of episodes with an empty queue.
  void gather_rows();
  void request();

  const Batch& batch_;
  ExternalPolicy& policy_;
  const WorkContext& context_;
  ChunkedPolicyOptions options_;
  int longest_chunk_ = 1;
  std::vector<EpisodeState> states_;
  // Arrays of the last request.
  std::vector<std::int32_t> rows_;
  std::vector<std::int32_t> episodes_;
  std::vector<std::int32_t> numbers_;
  std::vector<std::uint64_t> seeds_;
  std::vector<std::int32_t> steps_;
  std::vector<std::uint8_t> first_;
  std::vector<std::string> instructions_;
  std::vector<float> proprio_;
  std::vector<std::uint8_t> rgb_;
  std::vector<float> state_;
};

}  // namespace engram
