// A batch of environments of one task, stepped in lockstep.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/thread_pool.h"
#include "core/batch/options.h"
#include "core/batch/output_copies.h"
#include "core/image/image_batch.h"
#include "core/observe/object_view.h"
#include "core/perturb/command_queue.h"
#include "core/perturb/perturbation.h"
#include "core/sim/controller.h"
#include "core/sim/simulator.h"
#include "core/task/batch_task.h"
#include "core/task/task.h"

namespace engram {

class IeeeScope;

// Environments to reset, and their new seeds, pins and ranges. Empty spans: all environments; seeds
// and pins as before.
struct ResetRequest {
  std::span<const std::uint8_t> mask;      // num_envs values, non-zero: reset
  std::span<const std::uint64_t> seeds;    // num_envs values; those of masked-out ones are ignored
  const std::vector<Pin>* pins = nullptr;  // replaces the pins of the environments that are reset
  // Replaces their narrower ranges: range constants, [least, greatest] within those of the batch.
  const ConstantTable* constants = nullptr;
};

// Image observations of a batch, N = num_envs; empty in modes without them.
struct ObservedImages {
  // (N, height, width, 3 * cameras): each pixel has the cameras' colours in order.
  std::span<const std::uint8_t> rgb;
  // (N, height, width, cameras): mm along the camera's axis, 32767 at most, 0 where nothing is; and
  // an index into segmentation_names.
  std::span<const std::int16_t> depth;
  std::span<const std::int16_t> segmentation;
  // Names in all episodes: "background", then the scene's things in their order.
  std::span<const std::string> segmentation_names;
};

// Columns, reset and step. Beside it stand the modules that read or write a batch as a whole:
// Snapshotter, Queries, SceneRenderer and scripted policies.
//
// Computes in an IeeeScope whatever mode the calling thread has, and gives that back. All spans
// stay valid, and point to the same memory, for the life of the object; their content
// changes with step, reset and restore. Not for use from two threads at once.
class Batch {
 public:
  // Throws Error if an option is out of range, a pin or option is not the task's, or the machine
  // lacks memory, threads or the renderer. `renderers` is needed for images only.
  Batch(std::unique_ptr<Task> task, const BatchOptions& options, RendererFactory renderers = {});
  // The task has its constants and its horizon already: use make() (protocol/make/make.h).
  Batch(std::unique_ptr<Task> task, const MakeOptions& options,
        RendererFactory renderers = {}) = delete;
  ~Batch();

  const TaskInfo& info() const { return task_->info(); }
  // The given options, with defaults resolved: threads and chunk are numbers, not 0, and there is a
  // control mode.
  const BatchOptions& options() const { return options_; }
  int num_envs() const { return options_.num_envs; }
  ControlMode control_mode() const { return *options_.control_mode; }
  const PhysicsModel& physics_model() const { return *model_; }
  const ActionSpace& action_space() const { return controller_->action_space(); }
  int action_dim() const { return controller_->action_space().dim(); }
  // Fields of the observation's row, in their order: of the state, or in the objects modes of the
  // robot and the tokens.
  const std::vector<Field>& state_fields() const {
    return objects_ ? objects_->fields() : state_fields_;
  }
  // 7, or 8 with joint_proprio.
  int proprio_dim() const { return proprio_.width(); }
  int state_dim() const { return objects_ ? objects_->width() : observation_.width(); }

  // Starts new episodes. Without seeds, the first reset uses options().seed, and later ones begin
  // the next episode of each environment. Throws Error, changing nothing, if a span has the wrong
  // length or a pin is not allowed.
  void reset(const ResetRequest& request = {});

  // One control step for all environments. actions: (num_envs, action_dim), row by row. Throws
  // Error, changing nothing, if the length is wrong, a value is not finite or nothing was reset.
  void step(std::span<const float> actions);
  // A step in which environments with a 0 in `commanded`, (num_envs), go without a new command, as
  // in step_no_action.
  void step(std::span<const float> actions, std::span<const std::uint8_t> commanded);
  // One control step without a new command: the drives keep their targets, and the action of the
  // step before counts as this one's.
  void step_no_action();
  // Throws the errors of step for these actions, and does nothing else.
  void check_actions(std::span<const float> actions) const;

  // Outputs of the last step or reset; N = num_envs.
  std::span<const float> observation() const;        // (N, state_dim)
  std::span<const float> proprio() const;            // (N, proprio_dim): docs/robot.md
  std::span<const float> reward() const;             // (N)
  std::span<const std::uint8_t> terminated() const;  // (N)
  std::span<const std::uint8_t> truncated() const;   // (N)
  std::span<const std::uint8_t> success() const;     // (N)
  std::span<const std::uint8_t> unstable() const;    // (N) physics diverged in this step
  std::span<const std::uint8_t> final_mask() const;  // (N) 1: final_output is of this step
  ObservedImages images() const;
  // The last images of the episodes that final_mask marks (same-step mode).
  ObservedImages final_images() const;

  // All outputs by name: the above, the task's info fields, elapsed_steps, task_cue, oracle_info,
  // success_once, episode_return, ... . Throws Error for an unknown name.
  ColumnView output(std::string_view name) const;
  // An output at the end of each environment's last finished episode (same-step mode).
  ColumnView final_output(std::string_view name) const;
  const ColumnStore& outputs() const { return outputs_; }

  // Attaches a clock on which steps and resets count their time; null stops that. The clock must
  // have options().threads workers and live until then.
  void attach(StepClock* clock) { clock_ = clock; }

  // Attaches copies that are made of the outputs of every range of environments, by the thread that
  // has computed them; null stops that. They live until then.
  void attach(const OutputCopies* copies) { copies_ = copies; }
  // Arrays that take the place of this batch's own images, and outlive it; null: its own.
  void draw_into(const ImageTargets& now, const ImageTargets& finals = {});
  // Double buffer: the next step draws into these arrays.
  void swap_to(const ImageTargets& now);

  // The engine's columns, for tools and tests that look inside.
  const State& state() const { return state_; }
  const ColumnStore& memory() const { return memory_; }

 private:
  friend class BatchGroup;
  friend class Queries;
  friend class SceneRenderer;
  friend class ScriptedPolicy;
  friend class Snapshotter;

  static constexpr const char* kObservation = "observation";
  // Steps of an episode that goes on after its end are counted up to this.
  static constexpr std::int32_t kMaxElapsed = 1'000'000'000;

  // Under the scope.
  Batch(const IeeeScope&, std::unique_ptr<Task> task, const BatchOptions& options,
        RendererFactory renderers);
  void allocate();
  void add_state_fields();
  void add_outputs();
  void add_images();
  void add_objects();
  // Throw Error for an environment that does not exist, or before the first reset.
  void check_env(int env) const;
  void require_started(const char* what) const;
  // A reset whose arguments are checked.
  struct CheckedReset {
    const ResetRequest& request;
    const std::vector<Pin>* pins = nullptr;  // new ones
    std::vector<NarrowedRange> ranges;       // new ones, where the request has constants
    bool selects(int env) const {
      return request.mask.empty() || request.mask[static_cast<std::size_t>(env)] != 0;
    }
  };
  CheckedReset checked_reset(const ResetRequest& request) const;
  void reset_range(int worker, Range envs, const CheckedReset& reset);
  // The seed and the number of the episode that a reset begins in an environment.
  std::pair<std::uint64_t, std::uint64_t> next_episode(int env, const ResetRequest& request) const;
  void reset_env(int worker, int env, std::uint64_t seed, std::uint64_t episode);
  // The part of it without rules: the robot stands, and the task has sampled.
  void begin_episode(int worker, int env, std::uint64_t seed, std::uint64_t episode);
  // Throw Error. first: number of environment 0 in the message.
  void check_no_action(int first = 0) const;
  void refuse_ended(int first = 0) const;
  static void require_finite(std::span<const float> actions, std::size_t dim);
  // True for an environment that a step leaves alone, or resets.
  bool waits(int env) const {
    return state_.finished[env] != 0 && options_.after_end != AfterEnd::kContinue;
  }
  // actions: of all environments; null: none.
  void step_all(const float* actions);
  // Steps and resets of a task with BatchTask; commanded: empty, or 0 for environments without a
  // new command.
  void step_batch_task(const float* actions, std::span<const std::uint8_t> commanded);
  void reset_batch_task(const CheckedReset& reset);
  void list_steps();
  void move_stepping(const float* actions, std::span<const std::uint8_t> commanded);
  void judge(std::span<const int> envs);
  void end_steps();
  void begin_episodes();
  void step_range(int worker, Range envs, const float* actions);
  void simulate(int worker, Range envs, const float* actions);
  void run_physics(int worker, Range envs, const float* actions);
  void drive_by_queue(int worker, Range envs, std::span<DriveTarget> drives);
  void take_action(int env, const float* actions);
  RandomStream noise_stream(int env, std::uint32_t purpose) const {
    return {bindings_.stream_key(env), state_.episode[env], purpose};
  }
  void evaluate(Range envs);
  void fail_wrong_answers(int env);
  void finish_steps(int worker, Range envs);
  void finish_step(int worker, int env);
  // Sets the endings of a step, and keeps the last outputs of an episode that is replaced at once.
  // True if that one has ended.
  bool end_step(int env);
  bool outputs_finite(int env) const;
  void render_observation(int worker, int env);
  std::uint64_t image_noise_key(int env) const;
  void copy_outputs(Range envs) const {
    if (copies_ != nullptr) copies_->copy(envs, final_mask_.data());
  }
  StepClock::Worker* clock(int worker) const {
    return clock_ != nullptr ? &clock_->worker(worker) : nullptr;
  }
  void observe(Range envs);
  void observe_proprio(int env);
  void observe_robot(int env);
  // The task's part of the observation's rows.
  FloatRows task_rows();
  void observe_objects(int env);
  bool has_dense_reward() const;
  void compute_rewards(Range envs);
  void scale_reward(int env);
  template <class T>
  std::span<const T> whole(const Column<T>& column) const;

  // Environments of a step or reset by rules.
  struct RulesWork {
    std::vector<int> stepping;  // ascending
    std::vector<int> beginning;
    std::vector<std::uint8_t> begins;  // 1: an episode begins, whose seed and number are these
    std::vector<std::pair<std::uint64_t, std::uint64_t>> episodes;
  };

  std::unique_ptr<Task> task_;
  BatchTask* rules_ = nullptr;  // of the task, if it has some
  RulesWork work_;
  BatchOptions options_;
  std::vector<double> option_values_;          // of the task's own options
  std::shared_ptr<const PhysicsModel> model_;  // of all batches of this task
  std::unique_ptr<Controller> controller_;
  ThreadPool pool_;
  std::unique_ptr<Simulator> simulator_;
  RendererFactory renderers_;
  std::unique_ptr<ImageBatch> images_;  // rgb modes only
  ObjectTokens tokens_;
  std::unique_ptr<ObjectView> objects_;  // objects modes only

  ColumnStore memory_;         // everything an environment remembers of its episode
  ColumnStore pin_memory_;     // its pins, which outlive the episode
  ColumnStore outputs_;        // everything it shows
  ColumnStore final_outputs_;  // outputs at the end of the last episode (same-step mode)
  State state_;
  PinTable pins_;
  std::vector<Field> state_fields_;
  Bindings bindings_;
  Perturbations perturbations_;
  CommandQueue commands_;

  Column<float> observation_;
  Column<float> proprio_;
  Column<float> reward_;
  Column<std::uint8_t> terminated_;
  Column<std::uint8_t> truncated_;
  Column<std::uint8_t> unstable_;
  Column<std::int32_t> elapsed_steps_;
  Column<std::uint8_t> success_once_;
  Column<double> episode_return_;
  AlignedArray<std::uint8_t> final_mask_;

  const OutputCopies* copies_ = nullptr;
  StepClock* clock_ = nullptr;
  bool started_ = false;      // a first reset has been made
  bool interrupted_ = false;  // rules have failed in the middle of a step or reset
  std::atomic<std::uint64_t> unstable_count_ = 0;
};

}  // namespace engram
