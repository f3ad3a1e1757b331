// A task of the registry whose methods are called through BatchTask, environment by environment.
#pragma once

#include <memory>
#include <stdexcept>
#include <utility>

#include "core/task/batch_task.h"
#include "core/task/expert.h"

namespace engram::test {

class ListedTask final : public Task, public BatchTask {
 public:
  explicit ListedTask(std::unique_ptr<Task> task) : task_(std::move(task)) {}

  // The method that throws, once.
  enum class Failure { kNone, kReset, kBeforePhysics, kAdvance, kEvaluate, kReward };
  void fail_in(Failure failure) { failure_ = failure; }

  const TaskInfo& info() const override { return task_->info(); }
  SceneSpec scene() const override { return task_->scene(); }
  std::string document() const override { return task_->document(); }
  std::string drawn_document(const DrawnScene& drawn) const override {
    return task_->drawn_document(drawn);
  }
  std::vector<ObjectDescriptor> object_descriptors() const override {
    return task_->object_descriptors();
  }
  void bind(const Bindings& bindings) override { task_->bind(bindings); }
  void reset(const Episode& episode) override { task_->reset(episode); }
  using Task::before_physics;
  void advance(Range /*envs*/) override { throw std::logic_error("called for a range"); }
  void evaluate(Range /*envs*/) override { throw std::logic_error("called for a range"); }
  void observe(Range /*envs*/, FloatRows /*out*/) override { throw std::logic_error("a range"); }
  void dense_reward(Range /*envs*/, FloatRows /*out*/) override {
    throw std::logic_error("called for a range");
  }
  const Expert& expert() const override { throw std::logic_error("called for a range"); }
  BatchTask* batch_task() override { return this; }
  int cue_end(int env) const override { return task_->cue_end(env); }

  void reset(std::span<const int> /*envs*/) override { fail(Failure::kReset); }
  bool moves_before_physics() const override { return true; }
  void before_physics(std::span<const int> envs) override {
    fail(Failure::kBeforePhysics);
    for (const int env : envs) task_->before_physics({env, env + 1});
  }
  void advance(std::span<const int> envs) override {
    fail(Failure::kAdvance);
    for (const int env : envs) task_->advance({env, env + 1});
  }
  void evaluate(std::span<const int> envs) override {
    fail(Failure::kEvaluate);
    for (const int env : envs) task_->evaluate({env, env + 1});
  }
  void observe(std::span<const int> envs, FloatRows out) override {
    for (const int env : envs) task_->observe({env, env + 1}, out);
  }
  void dense_reward(std::span<const int> envs, FloatRows out) override {
    fail(Failure::kReward);
    for (const int env : envs) task_->dense_reward({env, env + 1}, out);
  }
  void act(std::span<const int> envs, Script script, FloatRows actions) override {
    for (const int env : envs) task_->expert().act({env, env + 1}, script, actions);
  }

 private:
  void fail(Failure here) {
    if (failure_ != here) return;
    failure_ = Failure::kNone;
    throw std::runtime_error("rules that fail");
  }

  std::unique_ptr<Task> task_;
  Failure failure_ = Failure::kNone;
};

}  // namespace engram::test
