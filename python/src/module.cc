// Extension module engram._core: the C API with Python's conventions:
// exceptions, arrays that keep their memory alive, and the GIL released while the library works.
// Users see the classes of engram/*.py instead.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "batch.h"
#include "calls.h"
#include "copies.h"
#include "evaluate.h"
#include "fields.h"
#include "images.h"
#include "task.h"

namespace engram_python {
namespace {

using namespace nb::literals;  // NOLINT: the way in which nanobind's literals are meant to be used

std::string list_json() {
  const char* text = engram_list_json();
  if (text == nullptr) raise(ENGRAM_UNAVAILABLE, engram_last_error());
  return text;
}

// Registering makes a task, whose code may be Python's: no thread waits for another one's
// registration while it has the GIL.
template <class Call>
void register_without_lock(Call&& call) {
  engram_status status = ENGRAM_OK;
  without_lock([&] { status = call(); });
  check(status);
}

void register_variant(const std::string& id, const std::string& base, const std::string& constants,
                      const std::optional<std::string>& instruction) {
  register_without_lock([&, id = c_text(id), base = c_text(base), values = c_text(constants),
                         text = instruction ? c_text(*instruction) : nullptr] {
    return engram_register_variant(id, base, values, text);
  });
}

void load_variants(const std::string& path) {
  register_without_lock([file = c_text(path)] { return engram_load_variants(file); });
}

void load_tasks(const std::string& path) { check(engram_load_tasks(c_text(path))); }

void bind_variants(nb::module_& module) {
  module.def("register_variant", &register_variant, "id"_a, "base"_a, "constants"_a,
             "instruction"_a.none());
  module.def("load_variants", &load_variants, "path"_a);
  module.def("load_tasks", &load_tasks, "path"_a);
}

// The fields of engram_options, in its order.
void bind_options(nb::module_& module) {
  nb::class_<Options> options(module, "Options", "What a batch is made of: engram_options.");
  options.def("__init__", [](Options* self) {
    new (self) Options();
    engram_options_init(&self->plain);
  });
  const auto field = field_binder(options);
  // begin generated: bindings (tools/surface, from api/surface.toml)
  field("num_envs", &engram_options::num_envs);
  field("threads", &engram_options::threads);
  field("chunk", &engram_options::chunk);
  field("substeps", &engram_options::substeps);
  field("seed", &engram_options::seed);
  field("obs_mode", &engram_options::obs_mode);
  field("reward_mode", &engram_options::reward_mode);
  field("auto_reset", &engram_options::auto_reset);
  field("control_mode", &engram_options::control_mode);
  field("rotation_sign", &engram_options::rotation_sign);
  field("freeze_cue", &engram_options::freeze_cue);
  field("terminate_on_success", &engram_options::terminate_on_success);
  field("sleep", &engram_options::sleep);
  field("robot_init_qpos_noise", &engram_options::robot_init_qpos_noise);
  field("observe_time", &engram_options::observe_time);
  field("joint_proprio", &engram_options::joint_proprio);
  field("lanes", &engram_options::lanes);
  field("rules", &engram_options::rules);
  field("image_width", &engram_options::image_width);
  field("image_height", &engram_options::image_height);
  field("renderer", &engram_options::renderer);
  field("shadows", &engram_options::shadows);
  field("antialias", &engram_options::antialias);
  field("render_shadows", &engram_options::render_shadows);
  field("terminate_on_failure", &engram_options::terminate_on_failure);
  field("after_end", &engram_options::after_end);
  field("max_episode_steps", &engram_options::max_episode_steps);
  field("physics", &engram_options::physics);
  // end generated
  options.def_rw("cameras", &Options::cameras)
      .def_rw("pins", &Options::pins)
      .def_rw("task_options", &Options::task_options)
      .def_rw("perturbations", &Options::perturbations)
      .def_rw("constants", &Options::constants);
}

// begin generated: array_queries
nb::tuple robot_state(const Batch& batch) {
  return batch.arrays({{9}, {9}, {7}}, [](engram_env* env, float* const* out) {
    return engram_robot_state(env, out[0], out[1], out[2]);
  });
}

nb::tuple camera_params(const Batch& batch, const std::string& camera, int width, int height) {
  const char* const camera_text = c_text(camera);
  return batch.arrays({{3, 4}, {4, 4}, {3, 3}}, [&](engram_env* env, float* const* out) {
    return engram_camera_params(env, camera_text, width, height, out[0], out[1], out[2]);
  });
}
// end generated

void bind_batch(nb::module_& module) {
  nb::class_<Batch>(module, "Batch", "A batch of environments: engram_env.")
      .def(nb::init<const std::string&, const Options&>(), "id"_a, "options"_a)
      .def(nb::init<const std::vector<TaskShare>&, const Options&>(), "tasks"_a, "options"_a)
      .def("close", &Batch::close)
      .def_prop_ro("closed", &Batch::closed)
      .def_prop_ro("num_envs", &Batch::num_envs)
      .def_prop_ro("num_threads", &Batch::num_threads)
      .def_prop_ro("action_dim", &Batch::action_dim)
      .def_prop_ro("state_dim", &Batch::state_dim)
      .def_prop_ro("horizon", &Batch::horizon)
      .def_prop_ro("unstable_count", &Batch::unstable_count)
      .def_prop_ro("action_bounds", &Batch::action_bounds)
      .def_prop_ro("description", &Batch::description)
      .def("reset", &Batch::reset, "mask"_a.noconvert().none() = nb::none(),
           "seeds"_a.noconvert().none() = nb::none(), "pins"_a.none() = nb::none(),
           "constants"_a.none() = nb::none())
      .def("step", &Batch::step, "actions"_a.noconvert())
      .def("step_no_action", &Batch::step_no_action)
      .def("step_async", &Batch::step_async, "actions"_a.noconvert())
      .def("step_wait", &Batch::step_wait)
      .def("act", &Batch::act, "policy"_a, "actions"_a.noconvert())
      .def("write_outputs", &Batch::write_outputs, "turns"_a)
      .def_prop_ro("output_buffer", &Batch::output_buffer)
      .def_prop_ro("output_names", &Batch::output_names)
      .def("output", &Batch::output, "name"_a)
      .def("final_output", &Batch::final_output, "name"_a)
      .def("instruction", &Batch::text_query<&engram_instruction>, "index"_a)
      // begin generated: queries
      .def("words", &Batch::text_query<&engram_words>, "index"_a)
      .def("question", &Batch::text_query<&engram_question>, "index"_a)
      .def("robot_state", &robot_state)
      .def("camera_params", &camera_params, "camera"_a, "width"_a, "height"_a)
      // end generated
      .def("ask", &Batch::ask, "index"_a)
      .def("answer", &Batch::answer, "index"_a, "choices"_a)
      .def("drawn", &Batch::drawn)
      .def("render", &Batch::render, "index"_a, "camera"_a, "width"_a, "height"_a)
      .def("mujoco", &Batch::mujoco, "index"_a)
      .def("save", &Batch::save, "index"_a)
      .def("restore", &Batch::restore, "index"_a, "bytes"_a);
}

void bind_copies(nb::module_& module) {
  nb::class_<Copies>(module, "Copies", "Copies of arrays, in memory that is used again.")
      .def(nb::init<>())
      .def("copy", &Copies::copy, "array"_a.noconvert())
      .def_prop_ro("spare", &Copies::spare);
}

}  // namespace
}  // namespace engram_python

NB_MODULE(_core, module) {
  // Environments that are still open when the interpreter exits are no defect.
  nanobind::set_leak_warnings(false);
  module.doc() = "engram's C API.";
  module.def("version", &engram_version);
  module.def("end_calls", &engram_python::end_calls);
  nanobind::module_::import_("atexit").attr("register")(module.attr("end_calls"));
  module.def("list_json", &engram_python::list_json);
  engram_python::bind_variants(module);
  engram_python::bind_options(module);
  engram_python::bind_batch(module);
  engram_python::bind_copies(module);
  engram_python::bind_images(module);
  engram_python::bind_evaluate(module);
  engram_python::bind_tasks(module);
  engram_python::bind_task_functions(module);
}
