// A fault to preload: every tenth collision has a contact that is one
// bit off, so that results depend on the order of the work.
#include <dlfcn.h>
#include <mujoco/mujoco.h>

#include <atomic>
#include <cmath>

extern "C" void mj_collision(const mjModel* model, mjData* data) {
  static const auto exact =
      reinterpret_cast<void (*)(const mjModel*, mjData*)>(dlsym(RTLD_NEXT, "mj_collision"));
  static std::atomic<int> calls = 0;
  exact(model, data);
  if (data->ncon > 0 && calls.fetch_add(1, std::memory_order_relaxed) % 10 == 9) {
    data->contact[0].dist = std::nextafter(data->contact[0].dist, 1.0);
  }
}
