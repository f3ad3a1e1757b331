// Plays trials in a batch, as many at a time as it has environments.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "protocol/eval/policies/episode_actor.h"
#include "protocol/eval/probe/question.h"
#include "protocol/eval/probe/trial.h"
#include "protocol/parallel/work_item.h"

namespace engram {

// A batch and the policy's actor in it.
struct PolicyBatch {
  Batch* batch = nullptr;
  EpisodeActor* actor = nullptr;
};

class TrialPlayer {
 public:
  using Labeller = std::function<EpisodeLabel(std::size_t trial)>;

  // main: of the trials; other: of the episodes between, which may be the same one, or has as many
  // environments. label: of a trial.
  TrialPlayer(const PolicyBatch& main, const PolicyBatch& other, Labeller label);

  // Results in the order of the trials; those that name a twin find it by its place among them.
  // Returns nothing if the context was stopped.
  std::vector<TrialResult> play(std::span<const Trial> trials, const WorkContext& context);

 private:
  // A trial under way in a slot.
  struct TrialState {
    enum class Phase { kIdle, kCue, kOther, kFree };
    Phase phase = Phase::kIdle;
    std::size_t trial = 0;
    std::size_t others = 0;         // episodes between that have begun
    std::vector<std::byte> paused;  // this trial at its question, meanwhile
  };

  bool shares_batch() const { return main_.batch == other_.batch; }
  std::uint64_t fill_slots(std::size_t& started);
  void compare_presents();
  void begin(int env, std::size_t trial);
  void begin_episode(const PolicyBatch& batch, int env, const EpisodeDraw& draw);
  void reach_question(int env);
  void begin_other(int env);
  void resume(int env);
  void act_and_step(const PolicyBatch& batch, bool other);
  void after_step(int env);
  void end_other(int env);
  void end(int env);

  PolicyBatch main_;
  PolicyBatch other_;
  Labeller label_;
  CuePolicy cue_policy_;
  std::span<const Trial> trials_;
  std::vector<TrialState> states_;  // by slot
  std::vector<TrialResult> results_;
  std::vector<std::vector<std::byte>> presents_;  // by trial
  std::size_t done_ = 0;
  std::vector<float> actions_;
  std::vector<std::uint8_t> commanded_;
  std::vector<int> showing_;  // slots before their question
};

}  // namespace engram
