// Memory of mjData: what many can share, and what one takes up.
#pragma once

#include <cstddef>
#include <memory>

#include "core/scene/mujoco_handle.h"

namespace engram {

// Working memory of MuJoCo's step, most of what an mjData takes up, which many mjData of a model
// use by turns: the stack, from which nothing is kept after a call, and the transposed Jacobian of
// the constraints, which a step makes anew. Newer versions of MuJoCo have both in an arena: nothing
// is shared there.
class MujocoWorkspace {
 public:
  explicit MujocoWorkspace(const mjModel& model);

 private:
  friend class WorkspaceLoan;
  std::unique_ptr<mjtNum[]> stack_;
  std::unique_ptr<mjtNum[]> jacobian_;
  std::unique_ptr<int[]> columns_;
};

// RAII guard: while it lives, the mjData uses the workspace's memory instead of its own.
class WorkspaceLoan {
 public:
  WorkspaceLoan(mjData& data, MujocoWorkspace& workspace);
  ~WorkspaceLoan() { exchange(); }
  WorkspaceLoan(const WorkspaceLoan&) = delete;
  WorkspaceLoan& operator=(const WorkspaceLoan&) = delete;

 private:
  void exchange();

  mjData& data_;
  mjtNum* stack_;
  mjtNum* jacobian_;
  int* columns_;
};

// Returns the pages of a stack to the system until they are written again.
void release_stack(mjData& data);

// Bytes of an mjData that are in memory: pages that have been written.
std::size_t resident_bytes(const DataPtr& data);

}  // namespace engram
