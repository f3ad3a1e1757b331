// Functions over arrays with a row per environment, for tasks that are written in Python.
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include "batch.h"
#include "engram/engram_task.h"
#include "task.h"

namespace engram_python {
namespace {

template <class T, int Dims>
using In = nb::ndarray<const T, nb::ndim<Dims>, nb::c_contig, nb::device::cpu>;
template <class T, int Dims>
using Out = nb::ndarray<T, nb::ndim<Dims>, nb::c_contig, nb::device::cpu>;
template <class T>
using AnyIn = nb::ndarray<const T, nb::c_contig, nb::device::cpu>;
template <class T>
using AnyOut = nb::ndarray<T, nb::c_contig, nb::device::cpu>;

// Raises InvalidArgumentError unless an array has that many rows of that many numbers.
template <class Array>
void require(const char* name, const Array& array, std::size_t rows, std::size_t numbers) {
  if (array.shape(0) == rows && array.size() == rows * numbers) return;
  const std::string message =
      std::string(name) + ": an array of " + std::to_string(array.shape(0)) + " rows and " +
      std::to_string(array.size()) + " numbers given, " + std::to_string(rows) + " rows of " +
      std::to_string(numbers) + " needed";
  raise(ENGRAM_INVALID_ARGUMENT, message.c_str());
}

int32_t count_of(std::size_t rows) { return static_cast<int32_t>(rows); }

void servo_tcp(const In<double, 2>& tcp_pos, const In<double, 2>& tcp_quat,
               const In<double, 2>& goal, const In<double, 2>& orientation,
               const In<double, 1>& gripper, const Out<float, 2>& out) {
  const std::size_t rows = tcp_pos.shape(0);
  require("tcp_pos", tcp_pos, rows, 3);
  require("tcp_quat", tcp_quat, rows, 4);
  require("goal", goal, rows, 3);
  require("orientation", orientation, rows, 4);
  require("gripper", gripper, rows, 1);
  require("out", out, rows, 7);
  check(engram_servo_tcp(count_of(rows), tcp_pos.data(), tcp_quat.data(), goal.data(),
                         orientation.data(), gripper.data(), out.data()));
}

void approach_from_above(const In<double, 2>& tcp_pos, const In<double, 2>& goal, double clearance,
                         const Out<double, 2>& out) {
  const std::size_t rows = tcp_pos.shape(0);
  require("tcp_pos", tcp_pos, rows, 3);
  require("goal", goal, rows, 3);
  require("out", out, rows, 3);
  check(engram_approach_from_above(count_of(rows), tcp_pos.data(), goal.data(), clearance,
                                   out.data()));
}

void descend(const In<double, 2>& tcp_pos, const In<double, 2>& goal, double travel_height,
             const Out<double, 2>& out) {
  const std::size_t rows = tcp_pos.shape(0);
  require("tcp_pos", tcp_pos, rows, 3);
  require("goal", goal, rows, 3);
  require("out", out, rows, 3);
  check(engram_descend(count_of(rows), tcp_pos.data(), goal.data(), travel_height, out.data()));
}

void tilt_outwards(const In<double, 2>& orientation, const In<double, 2>& point, double reach,
                   double per_metre, double most, const Out<double, 2>& out) {
  const std::size_t rows = orientation.shape(0);
  require("orientation", orientation, rows, 4);
  require("point", point, rows, 3);
  require("out", out, rows, 4);
  check(engram_tilt_outwards(count_of(rows), orientation.data(), point.data(), reach, per_metre,
                             most, out.data()));
}

void tour(const In<double, 2>& tcp_pos, const In<double, 2>& qvel,
          const In<std::int32_t, 1>& elapsed, const In<double, 3>& stops, double start_height,
          double reach, bool again, bool rests, const Out<double, 2>& goal_out,
          const Out<std::uint8_t, 1>& rest_out) {
  const std::size_t rows = tcp_pos.shape(0);
  require("tcp_pos", tcp_pos, rows, 3);
  require("qvel", qvel, rows, 9);
  require("elapsed", elapsed, rows, 1);
  require("stops", stops, rows, 3 * stops.shape(1));
  require("goal_out", goal_out, rows, 3);
  require("rest_out", rest_out, rows, 1);
  check(engram_tour(count_of(rows), tcp_pos.data(), qvel.data(), elapsed.data(), stops.data(),
                    static_cast<int32_t>(stops.shape(1)), start_height, reach, again ? 1 : 0,
                    rests ? 1 : 0, goal_out.data(), rest_out.data()));
}

void is_grasping(const In<double, 2>& tcp_quat, const In<double, 4>& finger_force, int prop,
                 double min_force, double max_angle, const Out<std::uint8_t, 1>& out) {
  const std::size_t rows = tcp_quat.shape(0);
  const std::size_t props = finger_force.shape(1);
  require("tcp_quat", tcp_quat, rows, 4);
  require("finger_force", finger_force, rows, 6 * props);
  require("out", out, rows, 1);
  check(engram_is_grasping(count_of(rows), tcp_quat.data(), finger_force.data(),
                           static_cast<int32_t>(props), prop, min_force, max_angle, out.data()));
}

void uniforms(const In<std::uint64_t, 1>& key, const In<std::uint64_t, 1>& episode, int count,
              const Out<double, 2>& out) {
  const std::size_t rows = key.shape(0);
  require("episode", episode, rows, 1);
  require("out", out, rows, static_cast<std::size_t>(std::max(count, 0)));
  check(engram_guesses(count_of(rows), key.data(), episode.data(), count, out.data()));
}

void real_function(const std::string& name, const AnyIn<double>& x,
                   const std::optional<AnyIn<double>>& y, const AnyOut<double>& out) {
  if (x.size() != out.size() || (y && y->size() != x.size())) {
    raise(ENGRAM_INVALID_ARGUMENT, "x, y and out: arrays of other sizes given, one size needed");
  }
  check(
      engram_real_function(c_text(name), x.size(), x.data(), y ? y->data() : nullptr, out.data()));
}

}  // namespace

void bind_task_functions(nb::module_& module) {
  using namespace nb::literals;  // NOLINT: the way in which nanobind's literals are meant to be
                                 // used
  module.def("servo_tcp", &servo_tcp, "tcp_pos"_a, "tcp_quat"_a, "goal"_a, "orientation"_a,
             "gripper"_a, "out"_a.noconvert());
  module.def("approach_from_above", &approach_from_above, "tcp_pos"_a, "goal"_a, "clearance"_a,
             "out"_a.noconvert());
  module.def("descend", &descend, "tcp_pos"_a, "goal"_a, "travel_height"_a, "out"_a.noconvert());
  module.def("tilt_outwards", &tilt_outwards, "orientation"_a, "point"_a, "reach"_a, "per_metre"_a,
             "most"_a, "out"_a.noconvert());
  module.def("tour", &tour, "tcp_pos"_a, "qvel"_a, "elapsed"_a, "stops"_a, "start_height"_a,
             "reach"_a, "again"_a, "rests"_a, "goal_out"_a.noconvert(), "rest_out"_a.noconvert());
  module.def("is_grasping", &is_grasping, "tcp_quat"_a, "finger_force"_a, "prop"_a, "min_force"_a,
             "max_angle"_a, "out"_a.noconvert());
  module.def("uniforms", &uniforms, "key"_a, "episode"_a, "count"_a, "out"_a.noconvert());
  module.def("real_function", &real_function, "name"_a, "x"_a, "y"_a.none(), "out"_a.noconvert());
}

}  // namespace engram_python
