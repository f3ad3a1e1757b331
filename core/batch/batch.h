// A batch of environments, of one task or of several, stepped in lockstep.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/batch/batch_data.h"
#include "core/batch/batch_outputs.h"
#include "core/batch/options.h"
#include "core/batch/reset_request.h"
#include "core/task/task.h"
#include "core/threads/thread_pool.h"

namespace engram {

// Outputs of the last step or reset that every task has, N = num_envs. More: Batch::output().
struct StepOutputs {
  std::span<const float> observation;  // (N, state_dim)
  std::span<const float> proprio;      // (N, 7 or 8), docs/robot.md
  std::span<const float> reward;       // (N), as all below
  std::span<const std::uint8_t> terminated;
  std::span<const std::uint8_t> truncated;
  std::span<const std::uint8_t> success;
  std::span<const std::uint8_t> unstable;    // 1: physics diverged in this step
  std::span<const std::uint8_t> final_mask;  // 1: the final outputs are of this step
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
// A batch of several tasks consists of parts, one for each task: batches of that task alone, whose
// environments follow one another. One loop over all threads steps them, and environment i of a
// part is, bit for bit, what it is without the others.
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
  // Several tasks, or one of them, with common arrays of outputs (BatchOutputs). parts: batches of
  // one task each, with the same options but for what is a task's own. threads: 0: one per
  // processor. Throws Error for no part, or different action spaces or observation modes.
  Batch(std::vector<std::unique_ptr<Batch>> parts, int threads);
  ~Batch();

  int num_envs() const { return num_envs_; }
  int threads() const { return pool_->threads(); }
  int action_dim() const { return action_space().dim(); }
  int state_dim() const;
  int horizon() const;  // the longest of all tasks
  const ActionSpace& action_space() const {
    return parts_.front().data().controller->action_space();
  }

  // True with common arrays of outputs.
  bool is_common() const { return data_ == nullptr; }
  int num_parts() const { return static_cast<int>(parts_.size()); }
  // A batch of one task is its own part.
  const Batch& part(int index) const { return *parts_[at(index)].batch; }
  // The part of an environment, and its number there. Throws Error if there is none.
  std::pair<int, int> locate(int env) const;

  // Facts of a batch of one task. These, images, columns and outputs by name throw Error for
  // several tasks.
  const TaskInfo& info() const { return data().info(); }
  // The given options, with defaults resolved: threads and chunk are numbers, not 0, and there is a
  // control mode.
  const BatchOptions& options() const { return data().options; }
  const PhysicsModel& physics_model() const { return *data().model; }

  // Starts new episodes. Without seeds, the first reset uses options().seed, and later ones begin
  // the next episode of each environment. Pins and constants must suit every task that has an
  // environment to reset. Throws Error, changing nothing, if a span has the wrong length or a pin
  // is not allowed.
  void reset(const ResetRequest& request = {});

  // One control step for all environments. actions: (num_envs, action_dim), row by row. Throws
  // Error, changing nothing, if a length is wrong, a value is not finite or nothing was reset.
  // Environments with a 0 in `commanded`, (num_envs) or empty, go without a new command, as in
  // step_no_action.
  void step(std::span<const float> actions, std::span<const std::uint8_t> commanded = {});
  // One control step without a new command: the drives keep their targets, and the action of the
  // step before counts as this one's.
  void step_no_action();
  // Throws the errors of step for these actions, and does nothing else.
  void check_actions(std::span<const float> actions) const;

  const StepOutputs& outputs() const { return outputs_; }
  ObservedImages images() const;
  // Any output by name: the above, the task's info fields, elapsed_steps, task_cue, oracle_info,
  // success_once, episode_return, ... . Throws Error for an unknown name.
  ColumnView output(std::string_view name) const;
  // An output at the end of each environment's last finished episode (same-step mode).
  ColumnView final_output(std::string_view name) const;
  // All outputs as arrays over the environments of all tasks.
  const BatchOutputs& output_arrays() const { return *arrays_; }
  // Outputs are written to arrays of the caller's as well, images to those alone; each as large
  // as the output. They outlive the batch. Each turn has arrays of the same outputs: the first
  // reset writes to those of turn 0, each step to those of the next turn, after the last one of
  // turn 0 again, later resets to those of the step before. Throws Error for a name or size that is
  // wrong, twice the same name, turns of different outputs, or after the first reset.
  void write_to(std::span<const std::vector<OutputTarget>> turns);

  // The engine's columns, for tools and tests that look inside.
  const State& state() const { return data().state; }

 private:
  friend struct BatchAccess;

  struct Part {
    Batch* batch = nullptr;
    std::unique_ptr<Batch> owned;  // null: the batch itself
    // Workers of the part that are in use; its ranges are at most as many as its workers.
    std::unique_ptr<std::atomic<bool>[]> busy;

    BatchData& data() const { return *batch->data_; }
  };
  // Environments of one part that one thread works on at a time.
  struct Segment {
    int part = 0;
    Range envs;
  };

  // Throws Error for several tasks.
  BatchData& data() const;
  void find_outputs();
  void step_all(const float* actions, std::span<const std::uint8_t> commanded);
  template <class F>
  void for_ranges(F&& f);
  template <class Loop>
  void run_listed(Loop&& loop);

  std::unique_ptr<BatchData> data_;  // of a batch of one task
  std::vector<Part> parts_;
  int num_envs_ = 0;
  std::vector<Segment> segments_;  // of several tasks
  std::optional<ThreadPool> pool_;
  std::optional<BatchOutputs> arrays_;
  StepOutputs outputs_;
};

// Access for the modules beside Batch, and for tools and tests that look inside.
struct BatchAccess {
  // Throws Error for a batch of several tasks.
  static BatchData& data(const Batch& batch) { return batch.data(); }
  // Calls f(part, worker, range) for all environments of tasks without BatchTask, on all threads.
  template <class F>
  static void for_ranges(Batch& batch, F&& f) {
    batch.for_ranges(std::forward<F>(f));
  }
};

// Claims a worker of a part for one range. There is always a free one.
class WorkerClaim {
 public:
  WorkerClaim(std::atomic<bool>* busy, int workers, int first) noexcept
      : busy_(busy), worker_(first % workers) {
    while (busy_[worker_].exchange(true, std::memory_order_acquire)) {
      worker_ = (worker_ + 1) % workers;
    }
  }
  ~WorkerClaim() { busy_[worker_].store(false, std::memory_order_release); }
  WorkerClaim(const WorkerClaim&) = delete;
  WorkerClaim& operator=(const WorkerClaim&) = delete;

  int worker() const noexcept { return worker_; }

 private:
  std::atomic<bool>* busy_;
  int worker_;
};

template <class F>
void Batch::for_ranges(F&& f) {
  if (data_ != nullptr && data_->batch_task == nullptr) {
    pool_->run(num_envs_, data_->options.chunk, [&](int worker, int begin, int end) {
      f(0, worker, Range{begin, end});
    });
  }
  if (segments_.empty()) return;
  pool_->run(static_cast<int>(segments_.size()), 1, [&](int worker, int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const Segment& segment = segments_[at(i)];
      const Part& part = parts_[at(segment.part)];
      const WorkerClaim claim(part.busy.get(), part.batch->threads(), worker);
      f(segment.part, claim.worker(), segment.envs);
    }
  });
}

}  // namespace engram
