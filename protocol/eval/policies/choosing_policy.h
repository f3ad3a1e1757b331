// External policies that name answers: they get the observations of an episode and the list of
// answers, and a scripted hand carries out the one that they name (docs/choices.md).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/batch/scripted_policy.h"
#include "protocol/eval/policies/choice_question.h"
#include "protocol/eval/policies/external_policy.h"
#include "protocol/make/object_text.h"

namespace engram {

struct ChoosingPolicyOptions {
  bool tell_seeds = false;        // questions have the episodes' seeds
  std::uint64_t policy_seed = 0;  // in all questions
  int stride = 1;                 // control steps between frames
};

class ChoosingPolicy final : public EpisodeActor {
 public:
  // The task has choices.
  ChoosingPolicy(Batch& env, ExternalPolicy& policy, const WorkContext& context,
                 const ChoosingPolicyOptions& options);

  void start(int slot, const EpisodeLabel& label) override;
  void go_on(int slot, const EpisodeLabel& label) override;
  void finish(int slot) override;
  void act(std::span<float> actions, std::span<std::uint8_t> commanded) override;
  const EpisodeDigests& digests(int slot) const override;

 private:
  // Frames since the last question. Those that look like the one before are left out.
  struct Frames {
    std::vector<std::int32_t> steps;
    std::vector<float> proprio;
    std::vector<std::uint8_t> rgb;
    std::vector<float> state;
    std::vector<std::string> texts;
  };
  struct Slot {
    EpisodeLabel label;
    std::int32_t questions = 0;  // asked so far
    Frames frames;
    EpisodeDigests digests;
  };

  void observe(int env, Slot& slot, bool due) const;
  bool is_as_before(const Frames& frames, const PolicyView& view, const std::string& text) const;
  void ask(int env, Slot& slot);

  Batch& env_;
  const Choices& choices_;
  const ChoiceForm form_;
  ScriptedPolicy hand_;
  ExternalPolicy& policy_;
  const WorkContext& context_;
  ChoosingPolicyOptions options_;
  std::optional<ObjectText> words_;  // in the mode that observes objects
  std::vector<Slot> slots_;
};

// The policy as an actor: it names answers, or sends actions if `stride` is 0.
std::unique_ptr<EpisodeActor> make_external_actor(Batch& env, ExternalPolicy& policy,
                                                  const WorkContext& context,
                                                  const ChunkedPolicyOptions& options, int stride);

}  // namespace engram
