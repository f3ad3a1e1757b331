// A batch of environments of one task, stepped in lockstep.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/thread_pool.h"
#include "core/env/env_options.h"
#include "core/env/object_view.h"
#include "core/env/task.h"
#include "core/image/camera_poses.h"
#include "core/image/image_batch.h"
#include "core/image/overlay.h"
#include "core/sim/controller.h"
#include "core/sim/simulator.h"

namespace engram {

class IeeeScope;

// Which environments to reset, and how. Empty spans: all environments; seeds and pins as before.
struct ResetRequest {
  std::span<const std::uint8_t> mask;      // num_envs values, non-zero: reset
  std::span<const std::uint64_t> seeds;    // num_envs values; those of masked-out ones are ignored
  const std::vector<Pin>* pins = nullptr;  // replaces the pins of the environments that are reset
  // Replaces their narrower ranges: range constants, [least, greatest] within those of the batch.
  const ConstantTable* constants = nullptr;
};

// Computes in an IeeeScope whatever mode the calling thread has, and gives that back. All spans
// stay valid, and point to the same memory, for the life of the object; their content
// changes with step, reset and restore. Not for use from two threads at once.
class Batch {
 public:
  // Throws Error if an option is out of range, a pin or option is not the task's, or the machine
  // lacks memory, threads or the renderer. `renderers` is needed for pictures only.
  Batch(std::unique_ptr<Task> task, const EnvOptions& options, RendererFactory renderers = {});
  ~Batch();

  const TaskInfo& info() const { return task_->info(); }
  const EnvOptions& options() const { return options_; }
  int num_envs() const { return options_.num_envs; }
  int threads() const { return pool_.threads(); }
  const ActionSpace& action_space() const { return controller_->action_space(); }
  int action_dim() const { return controller_->action_space().dim(); }
  // Fields of the observation's row, in their order: of the state, or in the objects modes of what
  // cameras could tell.
  const std::vector<Field>& state_fields() const {
    return objects_ ? objects_->fields() : state_fields_;
  }
  // The same with ranges; in the objects modes only.
  std::span<const RangedField> ranged_fields() const {
    return objects_ ? std::span(objects_->ranged_fields()) : std::span<const RangedField>();
  }
  int state_dim() const { return objects_ ? objects_->width() : observation_.width(); }
  // The sampled quantities of an episode, the engine's robot_noise first.
  const std::vector<Draw>& draws() const { return pins_.draws(); }
  // Values of info().options, in their order.
  std::span<const double> option_values() const { return option_values_; }
  // MJCF text of the whole scene.
  std::string document() const;
  const PhysicsModel& physics_model() const { return *model_; }

  // Starts new episodes. Without seeds, the first reset uses options().seed, and later ones begin
  // the next episode of each environment. Throws Error, changing nothing, if a span has the wrong
  // length or a pin is not allowed.
  void reset(const ResetRequest& request = {});

  // One control step for all environments. actions: (num_envs, action_dim), row by row. Throws
  // Error, changing nothing, if the length is wrong, a value is not finite or nothing was reset.
  void step(std::span<const float> actions);
  // Throws what step would throw for these actions, and does nothing else.
  void check_actions(std::span<const float> actions) const;

  // Writes actions for the next step, (num_envs, action_dim). Oracle and blind need
  // pd_ee_delta_pose. Throws Error if they cannot act or the length is wrong.
  void act(Policy policy, std::span<float> actions);

  // Draws environment `env` as it is now, row 0 on top: a sensor as observations show it, or
  // render_camera with the render_options. camera: one of the scene's (docs/cameras.md);
  // sides 1 to 4096 pixels; rgb: (height, width, 3). Throws Error for anything else, or before the
  // first reset.
  void render(int env, std::string_view camera, int width, int height, std::span<std::uint8_t> rgb);

  // The robot in all environments, in every observation mode: (N, 9) rad and m, (N, 9), and the
  // TCP's position and quaternion (w, x, y, z) in the world (N, 7). Empty spans are left out. These
  // three throw Error for other lengths, or before the first reset.
  void robot_state(std::span<float> qpos, std::span<float> qvel, std::span<float> tcp_pose) const;
  // A camera of the scene in all environments, for pictures of that size.
  void camera_params(std::string_view camera, int width, int height, const CameraSpans& out);
  // What the episodes have drawn, (N, drawn_dim), info().drawn in order. Privileged.
  void drawn(std::span<float> values) const;
  int drawn_dim() const;

  // Outputs of the last step or reset; N = num_envs.
  std::span<const float> observation() const;  // (N, state_dim)
  // (N, height, width, 3 * cameras): each pixel has the cameras' colours in order. rgb modes only.
  std::span<const std::uint8_t> rgb() const;
  // (N, height, width, cameras), in the modes that have them: mm along the camera's axis, 32767 at
  // most, 0 where nothing is; and what is seen, an index into segmentation_names().
  std::span<const std::int16_t> depth() const;
  std::span<const std::int16_t> segmentation() const;
  // The last images of the episodes that final_mask marks (same-step mode).
  std::span<const std::uint8_t> final_rgb() const;
  std::span<const std::int16_t> final_depth() const;
  std::span<const std::int16_t> final_segmentation() const;
  // The same in all episodes: "background", then the scene's things in their order. Empty unless
  // segmentation is observed.
  std::span<const std::string> segmentation_names() const;
  std::span<const float> proprio() const;            // (N, 7): see docs/robot.md
  std::span<const float> reward() const;             // (N)
  std::span<const std::uint8_t> terminated() const;  // (N)
  std::span<const std::uint8_t> truncated() const;   // (N)
  std::span<const std::uint8_t> success() const;     // (N)
  std::span<const std::uint8_t> unstable() const;    // (N) physics diverged in this step
  std::span<const std::uint8_t> final_mask() const;  // (N) 1: final_output is of this step

  // All outputs by name: the above, the task's info fields, elapsed_steps, task_cue, oracle_info,
  // success_once, episode_return, ... . Throws Error for an unknown name.
  ColumnView output(std::string_view name) const;
  // The same at the end of each environment's last finished episode (same-step mode).
  ColumnView final_output(std::string_view name) const;
  const ColumnStore& outputs() const { return outputs_; }
  std::string instruction(int env) const;
  // Adds what the task writes over pictures for people.
  void overlay(int env, Overlay& out) const;
  // The number of steps from which on nothing shows info().hidden_draw any more.
  int cue_end(int env) const;

  // How many environment steps have diverged since construction.
  std::uint64_t unstable_count() const { return unstable_count_.load(); }

  // Saves or restores one environment, or all, bit-exactly. A snapshot may be restored into any
  // slot of any batch of the same task, control mode, rules and task options. The other options are
  // those of that batch. restore throws Error, changing nothing, if the bytes are damaged or of
  // another task, version or number of environments.
  std::vector<std::byte> save(int env) const;
  void restore(int env, std::span<const std::byte> bytes);
  std::vector<std::byte> save() const;
  void restore(std::span<const std::byte> bytes);
  // How many bytes save returns; always the same. Throws Error where save would.
  std::size_t save_size(int env) const;
  std::size_t save_size() const;

  // From now on, steps and resets count their time on this clock; null stops that. The clock must
  // have threads() workers and live until then.
  void attach(StepClock* clock) { clock_ = clock; }

  // The engine's columns, for tools and tests that look inside.
  const State& state() const { return state_; }
  const ColumnStore& memory() const { return memory_; }
  // Bytes that every further environment adds.
  std::size_t bytes_per_env() const {
    return (images_ ? images_->bytes() : 0) + object_bytes() + memory_.row_bytes() +
           pin_memory_.row_bytes() + 2 * outputs_.row_bytes();
  }

 private:
  static constexpr const char* kObservation = "observation";
  // Steps of an episode that goes on after its end are counted up to this.
  static constexpr std::int32_t kMostElapsed = 1'000'000'000;

  // Under the scope.
  Batch(const IeeeScope&, std::unique_ptr<Task> task, const EnvOptions& options,
        RendererFactory renderers);
  void allocate();
  void check_env(int env) const;
  void reset_env(int worker, int env, std::uint64_t seed, std::uint64_t episode);
  void refuse_ended() const;
  // Whether a step leaves the environment alone, or resets it.
  bool waits(int env) const {
    return state_.finished[env] != 0 && options_.after_end != AfterEnd::kContinue;
  }
  void step_range(int worker, Range envs, const float* actions);
  void simulate(int worker, Range envs, const float* actions);
  void take_action(int env, const float* actions);
  void evaluate(Range envs);
  void finish_steps(int worker, Range envs);
  void finish_step(int worker, int env);
  bool outputs_finite(int env) const;
  void draw(int worker, int env);
  StepClock::Worker* clock(int worker) const {
    return clock_ != nullptr ? &clock_->worker(worker) : nullptr;
  }
  void observe(Range envs);
  void observe_state(Range envs);
  void observe_objects(int env);
  std::size_t object_bytes() const;
  void compute_rewards(Range envs);
  void random_action(int env, float* action) const;
  std::string snapshot_label() const;
  std::uint64_t snapshot_columns() const;
  std::size_t snapshot_row_bytes() const;
  std::size_t snapshot_bytes(int count) const;
  std::vector<std::byte> save_range(Range envs) const;
  void check_content(std::span<const std::byte> row) const;
  void check_snapshot(std::span<const std::byte> bytes, int count) const;
  void restore_range(Range envs, std::span<const std::byte> bytes);
  template <class T>
  std::span<const T> whole(const Column<T>& column) const;

  std::unique_ptr<Task> task_;
  EnvOptions options_;
  std::vector<double> option_values_;          // of the task's own options
  std::shared_ptr<const PhysicsModel> model_;  // of all batches of this task
  std::unique_ptr<Controller> controller_;
  ThreadPool pool_;
  std::unique_ptr<Simulator> simulator_;
  RendererFactory renderers_;
  std::unique_ptr<ImageBatch> images_;  // rgb modes only
  ObjectTokens tokens_;
  std::unique_ptr<ObjectView> objects_;   // objects modes only
  std::unique_ptr<CameraPoses> cameras_;  // from the first call for them on
  std::unique_ptr<SceneViews> views_;     // what render() draws, from its first call on
  std::unique_ptr<ImageSource> sensor_source_;
  std::unique_ptr<ImageSource> render_source_;

  ColumnStore memory_;         // everything an environment remembers of its episode
  ColumnStore pin_memory_;     // its pins, which outlive the episode
  ColumnStore outputs_;        // everything it shows
  ColumnStore final_outputs_;  // outputs at the end of the last episode (same-step mode)
  State state_;
  PinTable pins_;
  std::vector<Field> state_fields_;
  Bindings bindings_;

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

  StepClock* clock_ = nullptr;
  bool started_ = false;  // a first reset has been made
  std::atomic<std::uint64_t> unstable_count_ = 0;
};

}  // namespace engram
