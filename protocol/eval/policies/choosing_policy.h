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
#include "protocol/eval/policies/object_text.h"

namespace engram {

struct ChoosingPolicyOptions {
  bool tell_seeds = false;        // questions have the episodes' seeds
  std::uint64_t policy_seed = 0;  // in all questions
  int stride = 1;                 // control steps between frames
};

class ChoosingPolicy final : public EpisodeActor {
 public:
  // The task has choices.
  ChoosingPolicy(Batch& batch, ExternalPolicy& policy, const WorkContext& context,
                 const ChoosingPolicyOptions& options);

  void start(int env, const EpisodeLabel& label) override;
  void replace_scene(int env, const EpisodeLabel& label) override;
  void finish(int env) override;
  void act(std::span<float> actions, std::span<std::uint8_t> commanded) override;
  const EpisodeDigests& digests(int env) const override;

 private:
  // Frames since the last question. Those that look like the one before are left out.
  struct Frames {
    std::vector<std::int32_t> steps;
    std::vector<float> proprio;
    std::vector<std::uint8_t> rgb;
    std::vector<float> state;
    std::vector<std::string> texts;
  };
  struct EpisodeState {
    EpisodeLabel label;
    std::int32_t questions = 0;  // asked so far
    Frames frames;
    EpisodeDigests digests;
  };

  void observe(int env, EpisodeState& state, bool due) const;
  bool is_as_before(const Frames& frames, const PolicyView& view, const std::string& text) const;
  void ask(int env, EpisodeState& state);

  Batch& batch_;
  const AnswerController& controller_;
  const ChoiceForm form_;
  ScriptedPolicy script_;
  ExternalPolicy& policy_;
  const WorkContext& context_;
  ChoosingPolicyOptions options_;
  std::optional<ObjectText> words_;  // in the mode that observes objects
  std::vector<EpisodeState> states_;
};

// The policy as an actor: it names answers, or sends actions if `stride` is 0.
std::unique_ptr<EpisodeActor> make_external_actor(Batch& batch, ExternalPolicy& policy,
                                                  const WorkContext& context,
                                                  const ChunkedPolicyOptions& options, int stride);

}  // namespace engram
