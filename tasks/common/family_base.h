// Base class of every family: it owns the description, the scene and the engine's columns.
#pragma once

#include <string>
#include <vector>

#include "core/task/task.h"
#include "mjcf/scene.h"
#include "tasks/common/poses.h"
#include "tasks/common/state_row.h"
#include "tasks/registry.h"

namespace engram::tasks {

class FamilyBase : public Task {
 public:
  const TaskInfo& info() const final { return info_; }
  SceneSpec scene() const final;
  std::string document() const final { return mjcf::compose(scene_, mjcf::Detail::kFull); }
  std::string drawn_document(const DrawnScene& drawn) const final {
    return mjcf::compose_drawn(scene_, drawn);
  }
  std::vector<ObjectDescriptor> object_descriptors() const final;
  std::vector<std::string> paraphrases(std::string_view instruction) const final;
  void bind(const Bindings& bindings) override { engine_ = bindings; }
  // The declared constants, with the user's values.
  void set_constants(std::vector<TaskConstant> constants);

 protected:
  // The description begins with what the registry knows.
  explicit FamilyBase(const RegistryEntry& entry);

  // A family lists its state observation once, field beside value, in a member template
  //   template <class Row> void state_row(Row& row, int env) const;
  // (tasks/common/state_row.h). Its constructor declares the fields, its observe() writes them.
  template <class Family>
  void declare_state(const Family& family) {
    FieldLister lister;
    family.state_row(lister, 0);
    info_.state_fields = lister.take();
  }
  template <class Family>
  static void write_state(const Family& family, Range envs, FloatRows out) {
    for (int env = envs.begin; env < envs.end; ++env) {
      RowWriter row(out.row(env));
      family.state_row(row, env);
    }
  }

  // A member template sampled_row lists what episodes draw and scripts read, likewise. Angles,
  // lengths and speeds are real, all else are whole numbers.
  template <class Family>
  void declare_sampled_values(const Family& family) {
    FieldLister lister;
    family.sampled_row(lister, 0);
    info_.sampled_values = lister.take();
    for (Field& field : info_.sampled_values) {
      field.privileged = true;
      if (field.unit.empty() || field.unit == "control steps") field.dtype = DType::kInt32;
    }
  }
  template <class Family>
  static void write_sampled_values(const Family& family, int env, float* out) {
    RowWriter row(out);
    family.sampled_row(row, env);
  }

  // Queries that many families make (tasks/common/poses.h).
  Eigen::Vector3d tcp_pos(int env) const { return tasks::tcp_pos(*engine_.state, env); }
  Eigen::Vector3d prop_pos(int env, int prop) const {
    return tasks::prop_pos(*engine_.state, env, prop);
  }
  double gripper_width(int env) const {  // m, the sum of both finger positions
    const double* fingers = engine_.state->qpos.row(env) + kArmJoints;
    return fingers[0] + fingers[1];
  }
  Pose prop_pose(int env, int prop) const { return tasks::prop_pose(*engine_.state, env, prop); }

  TaskInfo info_;
  mjcf::Scene scene_;
  Bindings engine_;
};

}  // namespace engram::tasks
