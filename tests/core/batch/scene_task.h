// A task made of nothing but a scene and hooks, with which tests drive the engine.
#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/batch/batch.h"
#include "core/task/expert.h"
#include "mjcf/scene.h"
#include "tasks/common/task_info.h"
#include "tasks/common/tcp_servo.h"

namespace engram::test {

class SceneTask final : public Task {
 public:
  using Hook = std::function<void(int env)>;

  explicit SceneTask(std::vector<mjcf::Prop> props = {}) {
    parts.props = std::move(props);
    description.id = "SceneTask";
    description.family = "SceneTask";
    description.horizon = 100'000;
    description.state_fields = {{"marker", 1, DType::kFloat32, "", "the elapsed steps"}};
  }

  // To be filled in before the task is handed to an environment.
  TaskInfo description;
  mjcf::Scene parts;
  Hook on_reset = [](int) {};
  Hook on_before_physics = [](int) {};
  Hook on_advance = [](int) {};
  Hook on_evaluate = [](int) {};
  Hook on_observe = [](int) {};
  std::function<float(int)> reward = [](int) { return 0.0F; };

  Bindings engine;

  const TaskInfo& info() const override { return description; }
  SceneSpec scene() const override { return tasks::scene_source(parts); }
  std::string document() const override { return mjcf::compose(parts, mjcf::Detail::kFull); }
  std::string drawn_document(const DrawnScene& drawn) const override {
    return mjcf::compose_drawn(parts, drawn);
  }
  void bind(const Bindings& bindings) override { engine = bindings; }
  int cue_end(int /*env*/) const override { return 0; }
  void reset(const Episode& episode) override { on_reset(episode.env()); }
  void before_physics(Range envs) override { each(envs, on_before_physics); }
  void advance(Range envs) override { each(envs, on_advance); }
  void evaluate(Range envs) override { each(envs, on_evaluate); }
  void observe(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      on_observe(env);
      *out.row(env) = static_cast<float>(engine.state->elapsed[env]);
    }
  }
  void dense_reward(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) *out.row(env) = reward(env);
  }
  const Expert& expert() const override { return hold_; }

 private:
  class Hold final : public Expert {
   public:
    void act(Range envs, Script /*script*/, FloatRows actions) const override {
      for (int env = envs.begin; env < envs.end; ++env) {
        tasks::hold_tcp(tasks::kGripperOpen, actions.row(env));
      }
    }
  };

  static void each(Range envs, const Hook& hook) {
    for (int env = envs.begin; env < envs.end; ++env) hook(env);
  }

  Hold hold_;
};

}  // namespace engram::test
