// Batches of several tasks as one: stepped in lockstep by one loop over all threads, with outputs
// in common arrays. A single batch is a group as well.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/thread_pool.h"
#include "core/batch/batch.h"
#include "core/batch/group_outputs.h"

namespace engram {

// An array of the user's that an output is written to.
struct OutputTarget {
  std::string name;
  void* data = nullptr;
  std::size_t bytes = 0;
};

// N stands for the environments of all batches; those of the first one come first. Environment i of
// a batch is, bit for bit, what it is without the others.
class BatchGroup {
 public:
  // One batch; its own arrays are the outputs.
  explicit BatchGroup(std::unique_ptr<Batch> batch);
  // Several tasks, or one of them, with common arrays. All batches have the same options but for
  // what is a task's own. threads: 0: those of the largest batch. Throws Error for no batch, or
  // different action spaces or observation modes.
  BatchGroup(std::vector<std::unique_ptr<Batch>> batches, int threads);
  ~BatchGroup();

  bool is_common() const { return pool_.has_value(); }
  int num_envs() const { return num_envs_; }
  int threads() const { return is_common() ? pool_->threads() : part(0).options().threads; }
  int action_dim() const { return part(0).action_dim(); }
  int state_dim() const;
  int horizon() const;  // the longest
  int num_parts() const { return static_cast<int>(parts_.size()); }
  Batch& part(int index) const { return *parts_[static_cast<std::size_t>(index)].batch; }
  int first_env(int part) const { return parts_[static_cast<std::size_t>(part)].first; }
  // The part of an environment. Throws Error if there is no such environment.
  int part_of(int env) const;

  // Calls of Batch for all environments. Pins and constants must suit every task that has an
  // environment to reset.
  void reset(const ResetRequest& request = {});
  void step(std::span<const float> actions);
  void step_no_action();
  void check_actions(std::span<const float> actions) const;
  // As ScriptedPolicy::act.
  void act(Policy policy, std::span<float> actions);

  const std::vector<OutputArray>& outputs() const { return outputs_.arrays(); }
  const std::vector<OutputArray>& final_outputs() const { return outputs_.finals(); }
  const GroupOutputs& layout() const { return outputs_; }

  // Outputs are written to arrays of the user's as well, images to those alone; each as large as
  // the output. They outlive the group. second: arrays of the same outputs; steps write to the
  // first and the second in turns, resets to those of the step before. Throws Error for a name or
  // size that is wrong, twice the same name, or after the first reset.
  void write_to(std::span<const OutputTarget> first, std::span<const OutputTarget> second = {});
  // Where the outputs of the last step or reset are: 0: the first arrays, 1: the second.
  int output_buffer() const { return output_buffer_; }

 private:
  struct Part : GroupPart {
    std::unique_ptr<Batch> owned;
    // Copies and images of both turns.
    std::array<OutputCopies, 2> copies;
    std::array<ImageTargets, 2> images;
    // Workers of the batch that are in use; ranges of a batch are at most as many as its workers.
    std::unique_ptr<std::atomic<bool>[]> busy;
  };
  // Environments of one part that one thread works on at a time.
  struct Segment {
    int part = 0;
    Range envs;
  };

  void check_targets(std::span<const OutputTarget> targets) const;
  void add_targets(std::span<const OutputTarget> targets, std::size_t output_buffer);
  void attach();
  void take_turn();
  void show_images();
  void step_all(const float* actions);
  template <class F>
  void run(F&& f);

  int num_envs_ = 0;
  std::vector<Part> parts_;
  std::optional<ThreadPool> pool_;  // of a group with common arrays
  std::vector<Segment> segments_;
  GroupOutputs outputs_;
  // Users' arrays of images by the number of the output, of both turns.
  std::array<std::vector<std::pair<std::size_t, std::byte*>>, 2> user_images_;
  bool takes_turns_ = false;
  int output_buffer_ = 0;
};

}  // namespace engram
