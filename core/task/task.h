// Interface between a task and the engine.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/column.h"
#include "core/base/constant.h"
#include "core/scene/scene_spec.h"
#include "core/sim/control_mode.h"
#include "core/sim/state.h"
#include "core/task/answers.h"
#include "core/task/drawn_scene.h"
#include "core/task/episode.h"
#include "core/task/object_descriptor.h"
#include "core/task/task_constant.h"
#include "core/task/task_option.h"

namespace engram {

class Expert;     // core/task/expert.h
class Annotator;  // core/task/annotator.h
class BatchTask;  // core/task/batch_task.h
struct Overlay;   // core/image/overlay.h

// Rule by which an episode ends before its horizon.
enum class Termination { kNever, kSuccess, kSuccessOrFailed };

// A task in words and numbers; everything here is constant.
struct TaskInfo {
  std::string id;
  std::string family;
  std::string split;  // short, medium, long or extended
  std::string memory_type;
  std::string instruction;
  bool canonical = true;
  int horizon = 0;     // control steps
  int candidates = 1;  // equally likely answers: a guess is right with probability 1 / candidates
  // Success rate of a guess, where answers are not equally likely, or where a wrong one may
  // succeed; 0: what `estimate_guess` returns, or 1 / candidates.
  double guess_rate = 0;
  std::function<double()> estimate_guess;  // for rates that take milliseconds to compute
  // Definition of the robot's answer, and meaning of its number; empty: there is no such moment.
  std::string answer;
  // Rate of right first answers by guessing; 0: 1 / candidates.
  double answer_rate = 0;
  Termination termination = Termination::kNever;
  // Meaning of actions where a batch is given none.
  ControlMode control_mode = ControlMode::kPdEeDeltaPose;
  // The benchmark's canonical wrappers zero actions until the cue is over.
  bool frozen_cue = false;
  double success_reward = 1;    // dense reward at success; normalised rewards are divided by it
  int task_cue_dim = 0;         // values of the cue that policies may see; 0: none
  int oracle_dim = 0;           // values of oracle_info
  bool oracle_is_real = false;  // they are float32 (Bindings::oracle_values), not int32
  std::vector<RandomVariable> random_variables;  // sampled by an episode; users may pin them
  std::string hidden_variable;                   // the one that an agent has to remember
  std::vector<TaskOptionSpec> options;           // variants of the rules, for users to choose
  std::vector<TaskConstant> constants;           // class constants, and what users may change
  // A changed constant, instead of the batch's option.
  std::optional<double> robot_init_qpos_noise;
  std::vector<Field> reward_terms;                          // columns of info "reward_dict"
  std::vector<std::pair<std::string, std::string>> phases;  // name, condition on elapsed
  std::vector<Field> state_fields;  // of the state observation, after tcp_pose
  // Written by Task::sampled_values: float32, or whole numbers (int32).
  std::vector<Field> sampled_values;

  // The success rate of guessing.
  double chance() const {
    if (guess_rate > 0) return guess_rate;
    return estimate_guess ? estimate_guess() : 1.0 / candidates;
  }
  // The share of right first answers of guessing.
  double answer_chance() const { return answer_rate > 0 ? answer_rate : 1.0 / candidates; }
};

// Environments begin, ..., end - 1 of a batch.
struct Range {
  int begin = 0;
  int end = 0;
};

// Rows of a matrix of floats, one per environment of the batch.
struct FloatRows {
  float* data = nullptr;
  int stride = 0;  // floats from row to row

  float* row(int env) const { return data + static_cast<std::ptrdiff_t>(env) * stride; }
};

// Stores for a task's own columns, and the columns of the engine that it reads and fills in; given
// to it when a batch is made.
struct Bindings {
  const State* state = nullptr;       // outlives the task's use of it
  std::span<const double> options;    // values of info().options, in order; outlive it too
  const Arm* arm = nullptr;           // likewise
  ColumnStore* memory = nullptr;      // for what the task remembers; zero when an episode begins
  ColumnStore* outputs = nullptr;     // for info fields; zero when an episode begins
  Column<std::uint8_t> success;       // out of evaluate
  Column<std::uint8_t> failed;        // out of evaluate, where the family has it
  Column<std::int32_t> freeze_steps;  // out of reset: actions are frozen before this step count
  Column<std::int32_t> oracle_info;   // (oracle_dim) out of evaluate
  Column<float> oracle_values;        // instead of oracle_info where it is real
  Column<float> task_cue;             // (task_cue_dim) out of evaluate
  std::uint64_t stream_salt = 0;      // of random streams (core/task/episode.h)
  std::uint64_t policy_salt = 0;      // of those that scripted policies draw from
  Answers answers;                    // out of evaluate, where there is info().answer
  bool strict = false;                // whether a wrong first answer fails the episode
  Column<float> action;               // the action of this step, after the curriculum's freeze
  Column<float> previous_action;      // that of the step before; zeros at first

  // Key of the random streams of an environment's episode.
  std::uint64_t stream_key(int env) const { return state->seed[env] ^ stream_salt; }
  // Key of the policies' streams, whose draws are no part of the episode.
  std::uint64_t policy_key(int env) const { return stream_key(env) ^ policy_salt; }
};

// A task drives a batch through its phases. Calls get a range of environments, never one virtual
// call per environment and step; environments do not know of one another. One object serves one
// batch; different ranges may be worked on at the same time by different threads. A task that has
// BatchTask gets those calls instead.
class Task {
 public:
  virtual ~Task() = default;

  virtual const TaskInfo& info() const = 0;
  virtual SceneSpec scene() const = 0;
  // The whole scene for tools and renderers, lights and visual geometry included.
  virtual std::string document() const = 0;
  // The scene of a drawn episode, for MuJoCo's own step.
  virtual std::string drawn_document(const DrawnScene& drawn) const = 0;

  // Appearance of the scene's props, in their order.
  virtual std::vector<ObjectDescriptor> object_descriptors() const { return {}; }

  // Called once, before anything else below.
  virtual void bind(const Bindings& bindings) = 0;

  // Samples an episode for one environment. Its columns are zero, the robot is placed.
  virtual void reset(const Episode& episode) = 0;
  // Moves props before the physics of a step; `elapsed` is still that of the step before.
  virtual void before_physics(Range /*envs*/) {}
  // Brings the scene to the phase of `elapsed`: moves, parks, reveals and paints props. Called
  // once per control step, and once at reset with elapsed = 0.
  virtual void advance(Range envs) = 0;
  // Computes success and info from the state; changes no prop.
  virtual void evaluate(Range envs) = 0;
  // Writes the task's part of the state observation, info().state_fields in order.
  virtual void observe(Range envs, FloatRows out) = 0;
  // Writes the dense reward; rows have one element.
  virtual void dense_reward(Range envs, FloatRows out) = 0;
  // Scripted policies, for use after bind.
  virtual const Expert& expert() const = 0;
  // Words and labels of an episode, for data sets; null where a task has none. For use after bind.
  virtual const Annotator* annotator() const { return nullptr; }

  // What is called instead of all methods with ranges and of the expert; null: those.
  virtual BatchTask* batch_task() { return nullptr; }

  // The value of elapsed from which on nothing shows the hidden draw any more.
  virtual int cue_end(int env) const = 0;

  // Writes the values that one environment's episode has sampled, info().sampled_values in order.
  // Privileged.
  virtual void sampled_values(int /*env*/, float* /*out*/) const {}

  // The instruction of one environment's episode.
  virtual std::string instruction(int /*env*/) const { return info().instruction; }
  // Other wordings of an instruction of this task, with the same numbers or placeholders; empty
  // where there are none.
  virtual std::vector<std::string> paraphrases(std::string_view /*instruction*/) const {
    return {};
  }
  // Adds what is written over an image of one environment, apart from step and reward. Called for
  // people's views only, never for observations.
  virtual void overlay(int /*env*/, Overlay& /*out*/) const {}
};

}  // namespace engram
