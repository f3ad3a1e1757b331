#include "tasks/common/touch_latch.h"

#include <algorithm>
#include <array>

#include "tasks/common/poses.h"

namespace engram::tasks {

int touched_object(const double* points, int objects, const double* tcp, double radius) {
  int nearest = -1;
  double least = radius;
  for (int object = 0; object < objects; ++object) {
    const double distance = (Eigen::Map<const Eigen::Vector3d>(points + 3 * object) -
                             Eigen::Map<const Eigen::Vector3d>(tcp))
                                .norm();
    if (distance >= least) continue;
    least = distance;
    nearest = object;
  }
  return nearest;
}

void append_touch(std::int32_t* order, int length, int object) {
  std::int32_t* free = std::find(order, order + length, -1);
  *(free == order + length ? order : free) = object;
}

void TouchLatch::bind(const Bindings& bindings, double radius) {
  engine_ = bindings;
  radius_ = radius;
  touched_ = bindings.memory->add<std::uint8_t>("touched", params_.objects);
  if (params_.order_length > 0) {
    order_ = bindings.memory->add<std::int32_t>("touch_order", params_.order_length);
    bindings.memory->limit("touch_order", -1, params_.objects - 1);
  }
  if (!params_.repeats) return;
  lasting_ = bindings.memory->add<std::int32_t>("lasting_touch");
  bindings.memory->limit("lasting_touch", -1, params_.objects - 1);
  repeated_ = bindings.memory->add<std::uint8_t>("repeated_touch");
}

void TouchLatch::reset(int env) const {
  std::fill_n(touched_.row(env), params_.objects, std::uint8_t{0});
  if (params_.order_length > 0) std::fill_n(order_.row(env), params_.order_length, -1);
  if (params_.repeats) lasting_[env] = -1;
}

void TouchLatch::evaluate(int env, bool acting) const {
  const State& state = *engine_.state;
  if (params_.repeats) end_touch(env);
  if (!acting || !robot_is_static(state, env)) return;
  std::array<double, 3 * kMaxObjects> points{};
  for (int object = 0; object < params_.objects; ++object) {
    Eigen::Map<Eigen::Vector3d>(points.data() + 3 * object) = touch_point(env, object);
  }
  const int object =
      touched_object(points.data(), params_.objects, state.tcp_pos.row(env), radius_);
  if (object < 0) return;
  if (params_.repeats) note_repeat(env, object);
  if (touched_.row(env)[object] != 0) return;
  touched_.row(env)[object] = 1;
  if (params_.order_length > 0) append_touch(order_.row(env), params_.order_length, object);
}

void TouchLatch::end_touch(int env) const {
  constexpr double kAway = 1.25;  // of the radius: a tool at its edge does not touch twice
  const std::int32_t object = lasting_[env];
  if (object < 0) return;
  const Eigen::Map<const Eigen::Vector3d> tcp(engine_.state->tcp_pos.row(env));
  if ((touch_point(env, object) - tcp).norm() > kAway * radius_) lasting_[env] = -1;
}

void TouchLatch::note_repeat(int env, int object) const {
  if (touched_.row(env)[object] != 0 && lasting_[env] != object) repeated_[env] = 1;
  lasting_[env] = object;
}

Eigen::Vector3d TouchLatch::touch_point(int env, int object) const {
  return prop_pos(*engine_.state, env, object) + Eigen::Vector3d(0, 0, params_.height);
}

}  // namespace engram::tasks
