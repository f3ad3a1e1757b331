// Memory of mjData: what many can share, and what one takes up.
#pragma once

#include <cstddef>
#include <memory>

#include "core/scene/mujoco_handle.h"

namespace engram {

// Working memory of MuJoCo's step, nearly all of what an mjData takes up: the stack, and the arrays
// that a step makes anew. Many mjData of a model use it by turns, and it stays in the cache. Newer
// versions of MuJoCo have an arena: nothing is shared there.
class MujocoWorkspace {
 public:
  explicit MujocoWorkspace(const mjModel& model);

 private:
  friend class WorkspaceLoan;
  DataPtr data_;
};

// RAII guard: while it lives, the mjData uses the workspace's memory instead of its own for all but
// what a step begins with: positions, velocities, controls, forces, mocap poses and warm start.
class WorkspaceLoan {
 public:
  WorkspaceLoan(mjData& data, MujocoWorkspace& workspace);
  ~WorkspaceLoan() { exchange(); }
  WorkspaceLoan(const WorkspaceLoan&) = delete;
  WorkspaceLoan& operator=(const WorkspaceLoan&) = delete;

 private:
  void exchange();

  mjData& data_;
  mjData* workspace_;  // null where nothing is shared
};

// Returns the pages of a stack to the system until they are written again.
void release_stack(mjData& data);

// Bytes of an mjData that are in memory: pages that have been written.
std::size_t resident_bytes(const DataPtr& data);

}  // namespace engram
