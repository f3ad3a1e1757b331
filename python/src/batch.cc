#include "batch.h"

#include <unistd.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <string_view>

#include "background_calls.h"
#include "calls.h"
#include "task_failure.h"

namespace engram_python {
namespace {

const char* exception_name(engram_status status) {
  switch (status) {
    case ENGRAM_INVALID_ARGUMENT:
      return "InvalidArgumentError";
    case ENGRAM_UNKNOWN_ID:
      return "UnknownIdError";
    case ENGRAM_UNAVAILABLE:
      return "UnavailableError";
    case ENGRAM_BAD_STATE:
      return "BadStateError";
    case ENGRAM_IO:
      return "IoError";
    case ENGRAM_TASK_FAILED:
      return "TaskFailedError";
    default:
      return "InternalError";
  }
}

// Calls into the library without the GIL.
template <class Call>
void run(Call&& call) {
  engram_status status = ENGRAM_OK;
  without_lock([&] { status = call(); });
  check(status);
}

// Waits for a step of engram_step_async. Ctrl-C ends one in which a task in Python does not return.
void wait_for_step(engram_env* env) {
  constexpr double kPause = 0.05;  // s between two looks at signals
  std::optional<nb::python_error> interrupt;
  for (int32_t done = 0; done == 0;) {
    run([&] { return engram_step_wait_for(env, kPause, &done); });
    if (done != 0) break;
    if (unless_ended([] { return PyErr_CheckSignals(); }) != 0) interrupt.emplace();
    if (interrupt) interrupt_background_calls(interrupt->type());
  }
  if (interrupt) throw nb::python_error(std::move(*interrupt));
}

// Views of pins and options in the C API's types; they point into the arguments.
std::vector<engram_pin> as_pins(const NamedValues& pins) {
  std::vector<engram_pin> result;
  for (const auto& [name, values] : pins) {
    result.push_back({c_text(name), values.data(), values.size()});
  }
  return result;
}

// Outputs that frameworks take over without a copy and may write to; what is written there has no
// effect on the simulation. All others are read-only, because tasks may read them again.
bool is_writable(std::string_view name) {
  static constexpr std::string_view kWritable[] = {"observation",  "rgb",        "depth",
                                                   "segmentation", "proprio",    "task_cue",
                                                   "reward",       "terminated", "truncated"};
  return std::find(std::begin(kWritable), std::end(kWritable), name) != std::end(kWritable);
}

}  // namespace

nb::dlpack::dtype dtype_of(int32_t dtype) {
  switch (dtype) {
    case ENGRAM_BOOL:
      return nb::dtype<bool>();
    case ENGRAM_INT32:
      return nb::dtype<std::int32_t>();
    case ENGRAM_UINT64:
      return nb::dtype<std::uint64_t>();
    case ENGRAM_FLOAT32:
      return nb::dtype<float>();
    case ENGRAM_FLOAT64:
      return nb::dtype<double>();
    case ENGRAM_UINT8:
      return nb::dtype<std::uint8_t>();
    case ENGRAM_INT16:
      return nb::dtype<std::int16_t>();
    default:
      raise(ENGRAM_INTERNAL, "output of an unknown type");
  }
}

void raise(engram_status status, const char* message) {
  if (status == ENGRAM_TASK_FAILED) raise_task_failure();
  const nb::object type = nb::module_::import_("engram.errors").attr(exception_name(status));
  PyErr_SetString(type.ptr(), message);
  throw nb::python_error();
}

const char* c_text(const std::string& text) {
  const std::size_t end = text.find('\0');
  if (end == std::string::npos) return text.c_str();
  const std::string message =
      "'" + text.substr(0, end) + "' and a character 0 given, texts without one allowed";
  raise(ENGRAM_INVALID_ARGUMENT, message.c_str());
}

void check(engram_status status) {
  if (status != ENGRAM_OK) raise(status, engram_last_error());
}

// --- the handle ---

std::vector<engram_perturbation> as_perturbations(const NamedValue& levels) {
  std::vector<engram_perturbation> result;
  for (const auto& [axis, level] : levels) result.push_back({c_text(axis), level});
  return result;
}

std::vector<engram_task_option> as_task_options(const NamedValue& options) {
  std::vector<engram_task_option> result;
  for (const auto& [name, value] : options) result.push_back({c_text(name), value});
  return result;
}

namespace {

// Calls make with the options as the C API takes them.
template <class Make>
void make_with(const Options& options, Make&& make) {
  engram_options plain = options.plain;
  const std::vector<engram_pin> pins = as_pins(options.pins);
  plain.pins = pins.data();
  plain.num_pins = pins.size();
  const std::vector<engram_task_option> task_options = as_task_options(options.task_options);
  plain.task_options = task_options.data();
  plain.num_task_options = task_options.size();
  const std::vector<engram_perturbation> perturbations = as_perturbations(options.perturbations);
  plain.perturbations = perturbations.data();
  plain.num_perturbations = perturbations.size();
  plain.constants = options.constants.empty() ? nullptr : c_text(options.constants);
  std::vector<const char*> cameras;
  for (const std::string& camera : options.cameras) cameras.push_back(c_text(camera));
  plain.cameras = cameras.empty() ? nullptr : cameras.data();
  plain.num_cameras = cameras.size();
  run([&] { return make(&plain); });
}

}  // namespace

Handle::Handle(const std::string& id, const Options& options) : owner_(getpid()) {
  const char* task = c_text(id);
  make_with(options, [&](const engram_options* plain) { return engram_make(task, plain, &env_); });
}

Handle::Handle(const std::vector<TaskShare>& tasks, const Options& options) : owner_(getpid()) {
  std::vector<std::vector<engram_pin>> pins;
  std::vector<std::vector<engram_task_option>> task_options;
  std::vector<engram_task_share> shares;
  for (const auto& [id, num_envs, constants, own_pins, own_options] : tasks) {
    pins.push_back(as_pins(own_pins));
    task_options.push_back(as_task_options(own_options));
    shares.push_back({c_text(id), num_envs, constants.empty() ? nullptr : c_text(constants),
                      pins.back().data(), pins.back().size(), task_options.back().data(),
                      task_options.back().size()});
  }
  make_with(options, [&](const engram_options* plain) {
    return engram_make_group(shares.data(), shares.size(), plain, &env_);
  });
}

// A forked process has the batch's memory but none of its threads: it cannot close it.
Handle::~Handle() {
  if (!forked()) engram_close(env_);
}

bool Handle::forked() const { return getpid() != owner_; }

engram_env* Handle::env() const {
  if (forked()) {
    const std::string message = "this batch was made by process " + std::to_string(owner_) +
                                ", whose threads do not survive a fork; make one in process " +
                                std::to_string(getpid()) + " instead";
    raise(ENGRAM_BAD_STATE, message.c_str());
  }
  return env_;
}

// --- the batch ---

Batch::Batch(const std::string& id, const Options& options)
    : handle_(std::make_shared<Handle>(id, options)) {}

Batch::Batch(const std::vector<TaskShare>& tasks, const Options& options)
    : handle_(std::make_shared<Handle>(tasks, options)) {}

void Batch::close() {
  const std::shared_ptr<Handle> handle = handle_.exchange(nullptr);
  // Arrays may keep the handle alive; a running step is waited for here in any case.
  if (handle && !handle->forked()) {
    engram_env* env = handle->env();
    without_lock([env] { engram_step_wait(env); });
  }
}

std::shared_ptr<Handle> Batch::open() const {
  hold_back_locked();  // or a daemon thread would find that its batch was closed at the end
  std::shared_ptr<Handle> handle = handle_;
  if (!handle) raise(ENGRAM_BAD_STATE, "the environments are closed; make new ones");
  return handle;
}

std::pair<std::vector<float>, std::vector<float>> Batch::action_bounds() const {
  const std::shared_ptr<Handle> handle = open();
  engram_env* env = handle->env();
  const float* low = engram_action_low(env);
  const float* high = engram_action_high(env);
  const int dim = engram_action_dim(env);
  return {{low, low + dim}, {high, high + dim}};
}

std::string Batch::description() const {
  const std::shared_ptr<Handle> handle = open();
  const char* text = engram_describe_json(handle->env());
  if (text == nullptr) raise(ENGRAM_UNAVAILABLE, "no memory for the description of the task");
  return text;
}

void Batch::reset(std::optional<Mask> mask, std::optional<Seeds> seeds,
                  const std::optional<NamedValues>& pins,
                  const std::optional<std::string>& constants) {
  const std::shared_ptr<Handle> handle = open();
  engram_env* env = handle->env();
  const auto count = static_cast<std::size_t>(engram_num_envs(env));
  if ((mask && mask->size() != count) || (seeds && seeds->size() != count)) {
    raise(ENGRAM_INVALID_ARGUMENT, "reset mask or seeds: one value per environment is needed");
  }
  engram_reset_request request{};
  if (mask) request.mask = reinterpret_cast<const std::uint8_t*>(mask->data());
  if (seeds) request.seeds = seeds->data();
  std::vector<engram_pin> pinned;
  if (pins) {
    pinned = as_pins(*pins);
    request.pins = pinned.data();
    request.num_pins = pinned.size();
    request.has_pins = 1;
  }
  if (constants) request.constants = c_text(*constants);
  run([&] { return engram_reset(env, &request); });
}

void Batch::step(const Actions& actions) {
  const std::shared_ptr<Handle> handle = open();
  engram_env* env = handle->env();
  run([&] { return engram_step(env, actions.data(), actions.size()); });
}

void Batch::step_no_action() {
  const std::shared_ptr<Handle> handle = open();
  engram_env* env = handle->env();
  run([&] { return engram_step_no_action(env); });
}

void Batch::step_async(const Actions& actions) {
  const std::shared_ptr<Handle> handle = open();
  engram_env* env = handle->env();
  run([&] { return engram_step_async(env, actions.data(), actions.size()); });
}

void Batch::step_wait() {
  const std::shared_ptr<Handle> handle = open();
  wait_for_step(handle->env());
}

void Batch::act(int policy, const ActionsOut& actions) {
  const std::shared_ptr<Handle> handle = open();
  engram_env* env = handle->env();
  run([&] { return engram_act(env, policy, actions.data(), actions.size()); });
}

// --- what comes out ---

void Batch::write_outputs(const std::vector<std::vector<OutputTarget>>& turns) {
  const std::shared_ptr<Handle> handle = open();
  const std::size_t count = turns.empty() ? 0 : turns[0].size();
  std::vector<engram_output_target> all;
  for (const std::vector<OutputTarget>& targets : turns) {
    if (targets.size() != count) {
      raise(ENGRAM_INVALID_ARGUMENT,
            "arrays that take turns: all turns must be for the same outputs");
    }
    for (const auto& [name, array] : targets) {
      all.push_back({c_text(name), array.data(), array.nbytes()});
    }
  }
  run([&] { return engram_write_outputs(handle->env(), all.data(), turns.size(), count); });
}

std::vector<std::string> Batch::output_names() const {
  const std::shared_ptr<Handle> handle = open();
  engram_env* env = handle->env();
  std::vector<std::string> names;
  for (std::size_t i = 0; i < engram_num_outputs(env); ++i) {
    engram_array array{};
    check(engram_output_at(env, i, &array));
    names.emplace_back(array.name);
  }
  return names;
}

nb::object Batch::view(const engram_array& array) const {
  const nb::capsule owner(new std::shared_ptr<Handle>(open()), [](void* handle) noexcept {
    delete static_cast<std::shared_ptr<Handle>*>(handle);
  });
  std::size_t shape[4];
  std::copy_n(array.shape, array.ndim, shape);
  const auto dtype = dtype_of(array.dtype);
  const auto ndim = static_cast<std::size_t>(array.ndim);
  void* data = const_cast<void*>(array.data);
  if (is_writable(array.name)) {
    return nb::cast(nb::ndarray<nb::numpy>(data, ndim, shape, owner, nullptr, dtype));
  }
  return nb::cast(nb::ndarray<nb::numpy, nb::ro>(data, ndim, shape, owner, nullptr, dtype));
}

nb::object Batch::output(const std::string& name) const {
  const std::shared_ptr<Handle> handle = open();
  engram_array array{};
  check(engram_output(handle->env(), c_text(name), &array));
  return view(array);
}

nb::object Batch::final_output(const std::string& name) const {
  const std::shared_ptr<Handle> handle = open();
  engram_array array{};
  check(engram_final_output(handle->env(), c_text(name), &array));
  return view(array);
}

std::string Batch::copied(int index, decltype(&engram_instruction) function) const {
  const std::shared_ptr<Handle> handle = open();
  engram_env* env = handle->env();
  std::size_t length = 0;
  check(function(env, index, nullptr, 0, &length));
  std::string text(length + 1, '\0');
  check(function(env, index, text.data(), text.size(), &length));
  text.resize(length);
  return text;
}

void Batch::ask(int index) {
  const std::shared_ptr<Handle> handle = open();
  check(engram_ask(handle->env(), index));
}

void Batch::answer(int index, const std::vector<std::int32_t>& choices) {
  const std::shared_ptr<Handle> handle = open();
  check(engram_answer(handle->env(), index, choices.data(), choices.size()));
}

nb::object Batch::render(int index, const std::string& camera, int width, int height) const {
  const std::shared_ptr<Handle> handle = open();
  engram_env* env = handle->env();
  // The library refuses sides outside 1 to 4096; until then the buffer must merely exist.
  const auto side = [](int value) { return static_cast<std::size_t>(std::clamp(value, 1, 4096)); };
  const std::size_t size = side(width) * side(height) * 3;
  auto pixels = std::make_unique<std::uint8_t[]>(size);
  std::uint8_t* data = pixels.get();
  const char* view = c_text(camera);
  run([&] { return engram_render(env, index, view, width, height, data, size); });
  const nb::capsule owner(data,
                          [](void* bytes) noexcept { delete[] static_cast<std::uint8_t*>(bytes); });
  pixels.release();
  return nb::cast(
      nb::ndarray<nb::numpy, std::uint8_t>(data, {side(height), side(width), 3}, owner));
}

// --- on demand ---

namespace {

// A new array of floats, of a size that may be none.
struct Floats {
  explicit Floats(std::vector<std::size_t> sides) : shape(std::move(sides)) {
    for (const std::size_t side : shape) size *= side;
    values = std::make_unique<float[]>(std::max<std::size_t>(size, 1));
  }
  float* data() const { return values.get(); }
  nb::object array() {
    const nb::capsule owner(values.get(),
                            [](void* floats) noexcept { delete[] static_cast<float*>(floats); });
    float* held = values.release();
    return nb::cast(nb::ndarray<nb::numpy, float>(held, shape.size(), shape.data(), owner));
  }

  std::vector<std::size_t> shape;
  std::size_t size = 1;
  std::unique_ptr<float[]> values;
};

}  // namespace

nb::tuple Batch::arrays(
    std::initializer_list<std::vector<std::size_t>> shapes,
    const std::function<engram_status(engram_env*, float* const*)>& query) const {
  const std::shared_ptr<Handle> handle = open();
  engram_env* env = handle->env();
  std::vector<Floats> made;
  std::vector<float*> out;
  for (std::vector<std::size_t> shape : shapes) {
    shape.insert(shape.begin(), static_cast<std::size_t>(engram_num_envs(env)));
    out.push_back(made.emplace_back(std::move(shape)).data());
  }
  run([&] { return query(env, out.data()); });
  nb::list result;
  for (Floats& floats : made) result.append(floats.array());
  return nb::tuple(result);
}

nb::object Batch::drawn() const {
  const std::shared_ptr<Handle> handle = open();
  engram_env* env = handle->env();
  Floats values({static_cast<std::size_t>(engram_num_envs(env)),
                 static_cast<std::size_t>(engram_drawn_dim(env))});
  run([&] { return engram_drawn(env, values.data(), values.size); });
  return values.array();
}

// --- snapshots ---

nb::bytes Batch::save(int index) const {
  const std::shared_ptr<Handle> handle = open();
  engram_env* env = handle->env();
  std::size_t size = 0;
  run([&] { return engram_save(env, index, nullptr, 0, &size); });
  std::vector<char> bytes(size);
  run([&] { return engram_save(env, index, bytes.data(), bytes.size(), &size); });
  return nb::bytes(bytes.data(), bytes.size());
}

void Batch::restore(int index, const nb::bytes& bytes) {
  const std::shared_ptr<Handle> handle = open();
  engram_env* env = handle->env();
  run([&] { return engram_restore(env, index, bytes.c_str(), bytes.size()); });
}

}  // namespace engram_python
