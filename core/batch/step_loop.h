// The loop of a step and of a reset: stages of BatchData, and calls of the task between them. It is
// the same for tasks that are called by ranges and for those that are called for many environments
// at once; only its caller differs.
#pragma once

#include <utility>
#include <vector>

#include "core/batch/batch_data.h"

namespace engram {

// All stages of one range, on one thread, with the task's methods.
class RangeCaller {
 public:
  RangeCaller(BatchData& data, int worker, Range envs) : data_(data), worker_(worker), envs_(envs) {
    if (StepClock::Worker* const time = data.clock(worker)) time->start();
  }

  template <class Stage>
  void run(Stage&& stage) {
    stage(worker_, envs_);
  }
  void before_physics() {
    data_.for_runs(envs_, EnvStage::kStepping, [&](Range run) { data_.task->before_physics(run); });
    mark(data_.clock(worker_), StepPart::kTask);
  }
  void evaluate(EnvStage stage) {
    const bool steps = stage == EnvStage::kStepping;
    StepClock::Worker* const time = steps ? data_.clock(worker_) : nullptr;
    data_.for_runs(envs_, stage, [&](Range run) { data_.evaluate(*data_.task, run, steps, time); });
  }

 private:
  BatchData& data_;
  int worker_;
  Range envs_;
};

// Each stage of all environments on all threads, with the methods of BatchTask between the stages.
// Run: calls a stage with workers and ranges.
template <class Run>
class ListCaller {
 public:
  ListCaller(BatchData& data, Run run) : data_(data), run_(std::move(run)) {}

  template <class Stage>
  void run(Stage&& stage) {
    run_([&](int worker, Range envs) {
      if (StepClock::Worker* const time = data_.clock(worker)) time->start();
      stage(worker, envs);
    });
  }
  void before_physics() {
    if (!data_.batch_task->moves_before_physics()) return;
    if (const auto envs = data_.listed(EnvStage::kStepping); !envs.empty()) {
      data_.batch_task->before_physics(envs);
    }
  }
  void evaluate(EnvStage stage) {
    const auto envs = data_.listed(stage);
    if (stage == EnvStage::kBeginning && !envs.empty()) data_.batch_task->reset(envs);
    if (!envs.empty()) data_.evaluate(*data_.batch_task, envs, stage == EnvStage::kStepping);
  }

 private:
  BatchData& data_;
  Run run_;
};

template <class Caller>
void run_beginning(BatchData& data, Caller&& caller, const CheckedReset* reset) {
  caller.run([&](int worker, Range envs) { data.begin_episodes(worker, envs, reset); });
  caller.evaluate(EnvStage::kBeginning);
  caller.run([&](int worker, Range envs) { data.show_beginning(worker, envs); });
}

template <class Caller>
void run_step(BatchData& data, Caller&& caller, const StepActions& actions) {
  caller.run([&](int worker, Range envs) { data.begin_step(worker, envs, actions); });
  caller.before_physics();
  caller.run([&](int worker, Range envs) { data.simulate_active(worker, envs, actions); });
  caller.evaluate(EnvStage::kStepping);
  caller.run([&](int worker, Range envs) { data.finish(worker, envs); });
  run_beginning(data, caller, nullptr);
}

template <class Caller>
void run_reset(BatchData& data, Caller&& caller, const CheckedReset& request) {
  caller.run([&](int /*worker*/, Range envs) { data.choose_resets(envs, request); });
  run_beginning(data, caller, &request);
}

}  // namespace engram
