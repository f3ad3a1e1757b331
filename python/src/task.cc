#include "task.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <memory>

#include "background_calls.h"
#include "batch.h"
#include "calls.h"
#include "engram/engram_task.h"
#include "task_failure.h"

namespace engram_python {
namespace {

// Why a call failed: the exception's type and text.
std::string in_words(const nb::python_error& error) {
  const std::string type = nb::cast<std::string>(error.type().attr("__name__"));
  return type + ": " + nb::cast<std::string>(nb::str(error.value()));
}

// Runs f with the GIL. Returns 0, or 1 with the reason in the reply.
template <class F>
int with_lock(engram_task_reply* reply, F&& f) noexcept {
  if (calls_have_ended()) return 1;
  const Locked locked;
  const auto keep = [reply](nb::python_error&& error) {
    std::string words = "an exception without words";
    try {
      words = in_words(error);
    } catch (...) {  // of a __str__ that fails
    }
    engram_task_fail(reply, words.c_str());
    keep_task_failure(std::move(error));
    return 1;
  };
  try {
    unless_ended(f);
    return 0;
  } catch (nb::python_error& error) {
    return keep(std::move(error));
  } catch (const std::exception& error) {
    PyErr_SetString(PyExc_TypeError, error.what());
    return keep(nb::python_error());
  }
}

nb::object& instance_of(void* instance) { return *static_cast<nb::object*>(instance); }

// A view of a column's rows, which keeps their memory.
nb::object rows(const engram_task_array& array, void* data, int32_t num_envs) {
  engram_task_memory_retain(array.memory);
  const nb::capsule owner(array.memory, [](void* memory) noexcept {
    engram_task_memory_release(static_cast<engram_task_memory*>(memory));
  });
  const std::size_t shape[] = {static_cast<std::size_t>(num_envs),
                               static_cast<std::size_t>(array.width)};
  const nb::dlpack::dtype dtype = dtype_of(array.dtype);
  if (array.is_written != 0) {
    return nb::cast(nb::ndarray<nb::numpy>(data, 2, shape, owner, nullptr, dtype));
  }
  return nb::cast(nb::ndarray<nb::numpy, nb::ro>(data, 2, shape, owner, nullptr, dtype));
}

int create(void* user, const char* id, const char* constants, void** instance,
           engram_task_reply* reply) {
  return with_lock(reply, [&] {
    nb::object task = (*static_cast<nb::callable*>(user))(id, constants);
    engram_task_describe(reply, nb::cast<std::string>(task.attr("describe")()).c_str());
    *instance = new nb::object(std::move(task));
  });
}

int bind(void* instance, const engram_task_array* arrays, size_t count, int32_t num_envs,
         engram_task_reply* reply) {
  return with_lock(reply, [&] {
    nb::dict all;
    nb::dict subset_rows;
    for (std::size_t i = 0; i < count; ++i) {
      all[arrays[i].name] = rows(arrays[i], arrays[i].all, num_envs);
      subset_rows[arrays[i].name] = rows(arrays[i], arrays[i].subset_rows, num_envs);
    }
    instance_of(instance).attr("bind")(all, subset_rows);
  });
}

int call(void* instance, int32_t method, int32_t rows, int32_t of_all, engram_task_reply* reply) {
  const bool in_background = BackgroundCall::is_needed();
  return with_lock(reply, [&] {
    const BackgroundCall marked(in_background);
    // Ctrl-C ends also a step that Python's own loop would not.
    if (PyErr_CheckSignals() != 0) nb::raise_python_error();
    instance_of(instance).attr("call")(method, rows, of_all != 0);
  });
}

void destroy(void* instance) {
  if (calls_have_ended()) return;
  const Locked locked;
  delete static_cast<nb::object*>(instance);
}

void register_task(const std::string& definition, nb::callable factory) {
  static constexpr engram_task_callbacks kCallbacks = {sizeof(engram_task_callbacks), &create,
                                                       &bind, &call, &destroy};
  // For the life of the process, as the task.
  auto user = std::make_unique<nb::callable>(std::move(factory));
  engram_status status = ENGRAM_OK;
  const char* text = c_text(definition);
  without_lock([&] { status = engram_register_task(text, &kCallbacks, user.get()); });
  check(status);
  (void)user.release();
}

}  // namespace

void bind_tasks(nb::module_& module) {
  using namespace nb::literals;  // NOLINT: the way in which nanobind's literals are meant to be
                                 // used
  module.def("register_task", &register_task, "definition"_a, "factory"_a);
}

}  // namespace engram_python
