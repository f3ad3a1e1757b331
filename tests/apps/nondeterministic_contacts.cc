// A fault to preload: every tenth contact of a ball with a box is a nanometre off, so that
// results depend on the order of the work.
#include <atomic>

#include "core/scene/mujoco_versions.h"

namespace {

mjfCollision exact = nullptr;

// The pointers' types are those of the version's mjfCollision.
template <class Data>
int collide(const mjModel* model, Data* data, engram::MujocoContact* contacts, int geom1, int geom2,
            mjtNum margin) {
  static std::atomic<int> calls = 0;
  const int count = exact(model, data, contacts, geom1, geom2, margin);
  if (count > 0 && calls.fetch_add(1, std::memory_order_relaxed) % 10 == 9) {
    contacts[0].dist += 1e-9;
  }
  return count;
}

__attribute__((constructor)) void install() {
  mjfCollision& function = mjCOLLISIONFUNC[mjGEOM_SPHERE][mjGEOM_BOX];
  exact = function;
  function = collide;
}

}  // namespace
