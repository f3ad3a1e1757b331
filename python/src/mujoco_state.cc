// State of MuJoCo's data as NumPy arrays.
#include <mujoco/mujoco.h>

#include <algorithm>

#include "batch.h"
#include "calls.h"

namespace engram_python {
namespace {

// A copy of rows of `width` numbers; width 0: of one row.
nb::object copy_rows(const mjtNum* values, int rows, int width) {
  const std::vector<std::size_t> shape =
      width == 0 ? std::vector{static_cast<std::size_t>(rows)}
                 : std::vector{static_cast<std::size_t>(rows), static_cast<std::size_t>(width)};
  const int size = rows * std::max(width, 1);
  auto made = std::make_unique<double[]>(static_cast<std::size_t>(size));
  std::copy_n(values, size, made.get());
  const nb::capsule owner(made.get(),
                          [](void* numbers) noexcept { delete[] static_cast<double*>(numbers); });
  double* const held = made.release();
  return nb::cast(nb::ndarray<nb::numpy, double>(held, shape.size(), shape.data(), owner));
}

nb::tuple names(const mjModel& model, const int* addresses, int count) {
  nb::list result;
  for (int i = 0; i < count; ++i) result.append(nb::str(model.names + addresses[i]));
  return nb::tuple(result);
}

}  // namespace

nb::dict Batch::mujoco(int index) const {
  const std::shared_ptr<Handle> handle = open();
  engram_env* env = handle->env();
  const mjModel* model = nullptr;
  const mjData* data = nullptr;
  engram_status status = ENGRAM_OK;
  without_lock([&] {
    status = engram_mujoco_model(env, index, &model);
    if (status == ENGRAM_OK) status = engram_mujoco_data(env, index, &data);
  });
  check(status);
  nb::dict state;
  state["time"] = data->time;
  state["qpos"] = copy_rows(data->qpos, model->nq, 0);
  state["qvel"] = copy_rows(data->qvel, model->nv, 0);
  state["act"] = copy_rows(data->act, model->na, 0);
  state["ctrl"] = copy_rows(data->ctrl, model->nu, 0);
  state["xpos"] = copy_rows(data->xpos, model->nbody, 3);
  state["xquat"] = copy_rows(data->xquat, model->nbody, 4);
  state["mocap_pos"] = copy_rows(data->mocap_pos, model->nmocap, 3);
  state["mocap_quat"] = copy_rows(data->mocap_quat, model->nmocap, 4);
  state["body_names"] = names(*model, model->name_bodyadr, model->nbody);
  state["joint_names"] = names(*model, model->name_jntadr, model->njnt);
  return state;
}

}  // namespace engram_python
