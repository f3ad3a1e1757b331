// A batch of environments as a Python object, on top of the C API.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "engram/engram_c.h"

namespace engram_python {

namespace nb = nanobind;

using NamedValues = std::vector<std::pair<std::string, std::vector<double>>>;
using NamedValue = std::vector<std::pair<std::string, double>>;
// A task of several: id, environments, constants (JSON; empty: none), pins, task options.
using TaskShare = std::tuple<std::string, int, std::string, NamedValues, NamedValue>;
// An output and an array of the user's for it.
using OutputTarget = std::pair<std::string, nb::ndarray<nb::c_contig, nb::device::cpu>>;
using Actions = nb::ndarray<const float, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using ActionsOut = nb::ndarray<float, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Mask = nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Seeds = nb::ndarray<const std::uint64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

// Options of a batch, with the memory that pointers in engram_options refer to.
struct Options {
  engram_options plain;
  std::deque<std::string> texts;  // targets of its pointers
  NamedValues pins;
  NamedValue task_options;
  NamedValue perturbations;
  std::string constants;  // JSON; empty: none
  std::vector<std::string> cameras;

  Options() = default;
  Options(const Options&) = delete;
  Options& operator=(const Options&) = delete;
};

// Perturbations and task options as the C API takes them; they point into the given texts.
std::vector<engram_perturbation> as_perturbations(const NamedValue& levels);
std::vector<engram_task_option> as_task_options(const NamedValue& options);

// An open engram_env. Arrays that view its buffers share it, so that they outlive the batch.
class Handle {
 public:
  Handle(const std::string& id, const Options& options);
  Handle(const std::vector<TaskShare>& tasks, const Options& options);
  ~Handle();
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  // Raises BadStateError in a process that was forked off the one which made the batch.
  engram_env* env() const;
  bool forked() const;

 private:
  engram_env* env_ = nullptr;
  pid_t owner_;
};

class Batch {
 public:
  Batch(const std::string& id, const Options& options);
  Batch(const std::vector<TaskShare>& tasks, const Options& options);

  void close();
  bool closed() const { return handle_.load() == nullptr; }

  int num_envs() const { return engram_num_envs(open()->env()); }
  int num_threads() const { return engram_num_threads(open()->env()); }
  int action_dim() const { return engram_action_dim(open()->env()); }
  int state_dim() const { return engram_state_dim(open()->env()); }
  int horizon() const { return engram_horizon(open()->env()); }
  std::uint64_t unstable_count() const { return engram_unstable_count(open()->env()); }
  std::pair<std::vector<float>, std::vector<float>> action_bounds() const;
  std::string description() const;

  void reset(std::optional<Mask> mask, std::optional<Seeds> seeds,
             const std::optional<NamedValues>& pins, const std::optional<std::string>& constants);
  void step(const Actions& actions);
  void step_no_action();
  void step_async(const Actions& actions);
  void step_wait();
  void act(int policy, const ActionsOut& actions);

  // The arrays must outlive the batch.
  void write_outputs(const std::vector<std::vector<OutputTarget>>& turns);
  int output_buffer() const { return engram_output_buffer(open()->env()); }

  std::vector<std::string> output_names() const;
  nb::object output(const std::string& name) const;
  nb::object final_output(const std::string& name) const;
  // A text of an environment that the function of the C API copies.
  template <decltype(&engram_instruction) function>
  std::string text_query(int index) const {
    return copied(index, function);
  }
  // New arrays of these shapes behind (N), filled by query(env, out), a function of the C API.
  nb::tuple arrays(std::initializer_list<std::vector<std::size_t>> shapes,
                   const std::function<engram_status(engram_env*, float* const*)>& query) const;
  void ask(int index);
  void answer(int index, const std::vector<std::int32_t>& choices);
  // (N, width of all values).
  nb::object drawn() const;
  nb::object render(int index, const std::string& camera, int width, int height) const;

  // MuJoCo's state of an environment: arrays and names, by the names of MujocoState.
  nb::dict mujoco(int index) const;

  nb::bytes save(int index) const;
  void restore(int index, const nb::bytes& bytes);

 private:
  // The handle, held for as long as the caller needs it. Raises BadStateError if closed.
  std::shared_ptr<Handle> open() const;
  nb::object view(const engram_array& array) const;
  std::string copied(int index, decltype(&engram_instruction) function) const;

  std::atomic<std::shared_ptr<Handle>> handle_;  // null: closed
};

// NumPy's type for an engram_dtype.
nb::dlpack::dtype dtype_of(int32_t dtype);

// Raises the Python exception for a status, with the library's message. Needs the GIL.
[[noreturn]] void raise(engram_status status, const char* message);
// A text for the C API. Raises InvalidArgumentError if it holds a character 0, at which the C API
// would cut it off.
const char* c_text(const std::string& text);
// Raises the last error of this thread unless all is well.
void check(engram_status status);

}  // namespace engram_python
