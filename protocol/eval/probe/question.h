// From the beginning of an episode to its question: the robot rests while the cue shows.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "core/batch/scripted_policy.h"
#include "core/task/answer_controller.h"
#include "protocol/eval/probe/trial.h"
#include "protocol/make/make.h"

namespace engram {

// What the robots of slots do before their question.
class CuePolicy {
 public:
  explicit CuePolicy(Batch& batch);

  // An episode has begun in a slot; its question has come.
  void begin(int env) const;
  void end(int env) const;
  bool uses_controller() const { return controller_ != nullptr; }
  // True if nothing has shown the cue yet, and time alone will not.
  bool awaits_cue(int env) const;
  // Sets the actions of the next step of these slots: none, or a script's to bring the cue about.
  // Throws Error (kInvalidArgument) if scripts have no actions for the control mode.
  void act(std::span<const int> envs, std::span<float> actions, std::span<std::uint8_t> commanded);

 private:
  Batch& batch_;
  const AnswerController* controller_;  // which brings the cue about; or null
  ScriptedPolicy script_;
  std::vector<float> script_actions_;  // of all slots
};

// All that a policy and its user may see of a slot, in bits: its observation, the robot, and every
// output that is not privileged.
std::vector<std::byte> visible_state(const Batch& batch, int env);

// Looks into episodes before they are played: a batch of one environment.
class Lookahead {
 public:
  Lookahead(std::string_view id, const MakeOptions& options);

  const Batch& batch() const { return *batch_; }
  // True if a script has to bring about the cue of an episode.
  bool awaits_cue(const EpisodeDraw& draw);
  // Control steps from which on nothing shows the hidden draw; -1: the episode ends before.
  int cue_end(const EpisodeDraw& draw);
  // The right answer, as the task's oracle_info has it; empty if it has none.
  std::vector<double> right_answer(const EpisodeDraw& draw);
  // Snapshot of an episode when its question comes.
  std::shared_ptr<const std::vector<std::byte>> scene_at(const EpisodeDraw& draw, int question);

 private:
  void begin(const EpisodeDraw& draw);
  void step();

  std::unique_ptr<Batch> batch_;
  CuePolicy cue_policy_;
  std::vector<float> actions_;
};

}  // namespace engram
