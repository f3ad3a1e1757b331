// One task and its environments: columns, engine, and the stages of a step.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/index.h"
#include "core/base/step_clock.h"
#include "core/batch/options.h"
#include "core/batch/output_copies.h"
#include "core/batch/reset_request.h"
#include "core/image/image_batch.h"
#include "core/observe/object_view.h"
#include "core/perturb/command_queue.h"
#include "core/perturb/perturbation.h"
#include "core/sim/controller.h"
#include "core/sim/mujoco_physics.h"
#include "core/sim/simulator.h"
#include "core/task/batch_task.h"
#include "core/task/task.h"

namespace engram {

// Actions of one step, (num_envs, action_dim). Null, or a 0 in `commanded`, (num_envs): no new
// command.
struct StepActions {
  const float* values = nullptr;
  std::span<const std::uint8_t> commanded = {};

  bool has(int env) const {
    return values != nullptr && (commanded.empty() || commanded[at(env)] != 0);
  }
};

// Treatment of an environment by the step or reset under way.
enum class EnvStage : std::uint8_t { kHeld, kStepping, kBeginning };

// Data of Batch and of the modules beside it. Stages take ranges of environments, may run on
// several threads for different ones, and leave out environments in another EnvStage (step_loop.h).
struct BatchData {
  // Under an IeeeScope. Throws the errors of Batch's constructor.
  BatchData(std::unique_ptr<Task> task, const BatchOptions& options, RendererFactory renderers);
  ~BatchData();
  BatchData(const BatchData&) = delete;
  BatchData& operator=(const BatchData&) = delete;

  static constexpr const char* kObservation = "observation";
  // Steps of an episode that goes on after its end are counted up to this.
  static constexpr std::int32_t kMaxElapsed = 1'000'000'000;

  const TaskInfo& info() const { return task->info(); }
  int num_envs() const { return options.num_envs; }
  // The physics of the batch.
  PhysicsEngine& physics() const {
    return mujoco != nullptr ? static_cast<PhysicsEngine&>(*mujoco) : *simulator;
  }
  // Environments that threads do not share.
  int range_unit() const;
  int action_dim() const { return controller->action_space().dim(); }

  // Throw Error.
  void check_env(int env) const;
  void require_started(const char* what) const;
  void refuse_ended() const;
  CheckedReset checked_reset(const ResetRequest& request) const;

  // --- stages of a step or reset, in their order ---

  void choose_resets(Range envs, const CheckedReset& reset);
  // Chooses the stage of each environment; takes the actions of those that step.
  void begin_step(int worker, Range envs, const StepActions& actions);
  void simulate_active(int worker, Range envs, const StepActions& actions);
  // Phases, success, infos and the task's part of the observation; rewarded: and the dense reward.
  // Callee, Envs: Task and Range, or BatchTask and a list.
  template <class Callee, class Envs>
  void evaluate(Callee& callee, Envs envs, bool rewarded, StepClock::Worker* time = nullptr);
  // Observation, reward and ending of those that have stepped.
  void finish(int worker, Range envs);
  // Begins episodes. Where one has ended in this step, its reward and its endings stay.
  // reset: null in steps.
  void begin_episodes(int worker, Range envs, const CheckedReset* reset);
  void show_beginning(int worker, Range envs);

  // Calls f(range) for runs of neighbours in that stage.
  template <class F>
  void for_runs(Range envs, EnvStage wanted, F&& f) const {
    for (int env = envs.begin; env < envs.end;) {
      const int first = env;
      while (env < envs.end && stages[at(env)] == wanted) ++env;
      if (first < env) {
        f(Range{first, env});
      } else {
        ++env;
      }
    }
  }

  // Environments in that stage, in ascending order, until the next call.
  std::span<const int> listed(EnvStage stage);

  // --- outputs ---

  // All that is observed, from the columns.
  void observe(Range envs);
  void observe_robot(int env);
  void render(int worker, int env);
  void copy_outputs(Range envs) const {
    if (copies != nullptr) copies->copy(envs, final_mask.data());
  }
  // Key of the sensors' noise in this step.
  std::uint64_t image_noise_key(int env) const;
  StepClock::Worker* clock(int worker) const {
    return step_clock != nullptr ? &step_clock->worker(worker) : nullptr;
  }

  int first_env = 0;  // number of environment 0 in the whole batch, which may have several parts
  std::unique_ptr<Task> task;
  BatchTask* batch_task = nullptr;  // the task, if it is one
  BatchOptions options;
  std::vector<double> option_values;          // of the task's own options
  std::shared_ptr<const PhysicsModel> model;  // of all batches of this task
  std::unique_ptr<Controller> controller;
  std::unique_ptr<Simulator> simulator;   // kinematics, and engram's own physics
  std::unique_ptr<MujocoPhysics> mujoco;  // MuJoCo's; null: engram's own
  RendererFactory renderers;
  std::unique_ptr<ImageBatch> images;  // modes with images only
  ObjectTokens tokens;
  std::unique_ptr<ObjectView> objects;  // objects modes only

  ColumnStore memory;         // everything an environment remembers of its episode
  ColumnStore pin_memory;     // its pins, which outlive the episode
  ColumnStore outputs;        // everything it shows
  ColumnStore final_outputs;  // outputs at the end of the last episode (same-step mode)
  State state;
  PinTable pins;
  std::vector<Field> state_fields;
  Bindings bindings;
  Perturbations perturbations;
  CommandQueue commands;

  Column<float> observation;
  Column<float> proprio;
  Column<float> reward;
  Column<std::uint8_t> terminated;
  Column<std::uint8_t> truncated;
  Column<std::uint8_t> unstable;
  Column<std::int32_t> elapsed_steps;
  Column<std::uint8_t> success_once;
  Column<double> episode_return;
  AlignedArray<std::uint8_t> final_mask;
  std::vector<EnvStage> stages;
  std::vector<int> list;  // for BatchTask

  const OutputCopies* copies = nullptr;  // made of the outputs of every range by its thread
  StepClock* step_clock = nullptr;       // on which steps and resets count their time
  bool started = false;                  // a first reset has been made
  bool interrupted = false;              // the task has failed in the middle of a step or reset
  std::atomic<std::uint64_t> unstable_count = 0;

 private:
  void allocate();
  void add_state_fields();
  void add_outputs();
  void add_images();
  void add_objects();
  std::pair<std::uint64_t, std::uint64_t> next_episode(int env, const CheckedReset* reset) const;
  void begin_episode(int worker, int env, std::uint64_t seed, std::uint64_t number);
  bool is_done(int env) const {
    return state.finished[env] != 0 && options.after_end != AfterEnd::kContinue;
  }
  void take_action(int env, const float* actions);
  void run_physics(int worker, Range envs, const float* actions);
  void drive_by_queue(int worker, Range envs, std::span<DriveTarget> drives);
  RandomStream noise_stream(int env, std::uint32_t purpose) const {
    return {bindings.stream_key(env), state.episode[env], purpose};
  }
  void fail_wrong_answers(Range envs);
  void fail_wrong_answers(std::span<const int> envs);
  void fail_wrong_answer(int env);
  bool has_dense_reward() const {
    return options.reward_mode == RewardMode::kDense ||
           options.reward_mode == RewardMode::kNormalizedDense;
  }
  void scale_reward(int env);
  bool end_step(int env);
  bool outputs_finite(int env) const;
  FloatRows task_rows();
  void observe_proprio(int env);
};

template <class Callee, class Envs>
void BatchData::evaluate(Callee& callee, Envs envs, bool rewarded, StepClock::Worker* time) {
  callee.advance(envs);
  callee.evaluate(envs);
  if (bindings.strict) fail_wrong_answers(envs);
  mark(time, StepPart::kTask);
  if (observes_state(options.obs_mode)) callee.observe(envs, task_rows());
  mark(time, StepPart::kObservation);
  if (rewarded && has_dense_reward()) callee.dense_reward(envs, {reward.data(), 1});
  mark(time, StepPart::kTask);
}

}  // namespace engram
