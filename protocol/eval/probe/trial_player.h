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

  // Takes the results of a group, in the order of its trials, as soon as all of them are known.
  using TakeGroup = std::function<void(std::size_t group, std::span<const TrialResult> results)>;

  // sizes: of the groups that the trials are in; those that name a twin find it by its place among
  // all trials. Returns early if the context was stopped.
  void play(std::span<const Trial> trials, std::span<const std::uint32_t> sizes,
            const WorkContext& context, const TakeGroup& take);

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
  void finish(std::size_t trial);
  void compare_presents(std::size_t first, std::size_t end);
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
  // A group's trials first to end - 1, of which some are not done.
  struct Group {
    std::size_t first = 0;
    std::size_t end = 0;
    std::size_t left = 0;
  };
  std::vector<Group> groups_;
  std::vector<std::size_t> group_of_;  // by trial
  TakeGroup take_;
  std::vector<TrialState> states_;  // by slot
  std::vector<TrialResult> results_;
  std::vector<std::vector<std::byte>> presents_;  // by trial
  std::size_t done_ = 0;
  std::vector<float> actions_;
  std::vector<std::uint8_t> commanded_;
  std::vector<int> showing_;  // slots before their question
};

}  // namespace engram
