// The C API as a state machine: calls in any order with any arguments. Batches that have
// been made outlive an execution, because making one takes long: they are brought back to a known
// state by a snapshot.
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <vector>

#include "engram/engram_c.h"
#include "tests/fuzz/input.h"

namespace engram::fuzz {
namespace {

constexpr const char* kNames[] = {"RememberColor3-VLA-v0",
                                  "RememberColour3-VLA-v0",
                                  "",
                                  "reward",
                                  "observation",
                                  "rgb",
                                  "final_mask",
                                  "target",
                                  "robot_noise",
                                  "base_camera",
                                  "render_camera",
                                  "pd_joint_pos",
                                  "pd_ee_delta_pose",
                                  "cpu",
                                  "touch_radius"};
constexpr std::int32_t kNumbers[] = {0, 1, 2,  3,  -1,        4,         5,
                                     7, 8, 14, 64, 1'000'001, INT32_MAX, INT32_MIN};
constexpr double kReals[] = {0, 1, 0.02, -1, 2, 1e300, NAN, INFINITY};

std::int32_t number(Input& input) { return kNumbers[input.choice(std::size(kNumbers))]; }
double real(Input& input) { return kReals[input.choice(std::size(kReals))]; }

// Texts of an execution, which stay where they are.
using Texts = std::deque<std::string>;

// A name that means something, or any text, or none.
const char* name(Input& input, Texts& texts) {
  const int which = input.choice(std::size(kNames) + 2);
  if (which < static_cast<int>(std::size(kNames))) return kNames[which];
  if (which == static_cast<int>(std::size(kNames))) return nullptr;
  return texts.emplace_back(input.text()).c_str();
}

engram_status checked(engram_status status) {
  require(status >= ENGRAM_OK && status < ENGRAM_INTERNAL, engram_last_error());
  ++(status == ENGRAM_OK ? tally.accepted : tally.refused);
  if (status != ENGRAM_OK) require(*engram_last_error() != '\0', "a failure without a message");
  return status;
}

// A batch that outlives executions.
struct Batch {
  engram_env* env = nullptr;
  std::vector<std::uint8_t> start;

  explicit Batch(const engram_options& options) {
    require(engram_make(kNames[0], &options, &env) == ENGRAM_OK, engram_last_error());
    require(engram_reset(env, nullptr) == ENGRAM_OK, engram_last_error());
    std::size_t size = 0;
    require(engram_save(env, ENGRAM_WHOLE_BATCH, nullptr, 0, &size) == ENGRAM_OK, "size");
    start.resize(size);
    require(engram_save(env, ENGRAM_WHOLE_BATCH, start.data(), size, &size) == ENGRAM_OK, "save");
  }
  // Ends a step that was left under way, and goes back to the start.
  void rewind() {
    engram_step_wait(env);
    require(engram_restore(env, ENGRAM_WHOLE_BATCH, start.data(), start.size()) == ENGRAM_OK,
            engram_last_error());
  }
};

std::vector<Batch>& batches() {
  // Never destroyed: they are in use until the process ends.
  static std::vector<Batch>& all = *new std::vector<Batch>([] {
    std::vector<Batch> made;
    engram_options options;
    engram_options_init(&options);
    options.num_envs = 2;
    options.threads = 1;
    options.substeps = 0;
    made.emplace_back(options);
    options.auto_reset = ENGRAM_AUTO_RESET_SAME_STEP;
    options.control_mode = "pd_joint_target_delta_pos";
    options.substeps = 1;
    made.emplace_back(options);
    options.auto_reset = ENGRAM_AUTO_RESET_OFF;
    options.control_mode = "pd_joint_pos";
    options.obs_mode = ENGRAM_OBS_RGB;
    options.image_width = options.image_height = 2;
    options.num_envs = 1;
    options.substeps = 0;
    made.emplace_back(options);
    return made;
  }());
  return all;
}

// State of an execution.
struct Run {
  Input input;
  std::vector<engram_env*> made = {};  // by this execution, and closed at its end
  int attempts = 0;                    // to make one
  std::vector<std::uint8_t> snapshot = {};
  Texts texts = {};

  engram_env* env() {
    const int which = input.choice(8);
    if (which == 7) return nullptr;
    if (which >= 4 && !made.empty()) return made.back();
    return batches()[static_cast<std::size_t>(which) % batches().size()].env;
  }
  // Mostly as many values as needed: numbers in -1..1, and now and then something else.
  std::vector<float> actions(const engram_env* of) {
    const int form = input.choice(16);
    auto count =
        static_cast<std::size_t>(of == nullptr ? 7 : engram_num_envs(of) * engram_action_dim(of));
    if (form == 0) count = input.take<std::uint8_t>();
    std::vector<float> values(count);
    for (std::size_t i = 0; i < count; ++i) values[i] = 0.1F * static_cast<float>(i % 7);
    if (form == 1 && count > 0) values[count / 2] = input.take<float>();
    if (form == 2) std::fill(values.begin(), values.end(), input.take<float>());
    return values;
  }
};

// --- making ---

engram_options any_options(Run& run, std::array<engram_pin, 2>& pins, std::array<double, 8>& values,
                           engram_task_option& choice, engram_perturbation& perturbation,
                           std::array<const char*, 3>& cameras) {
  Input& input = run.input;
  engram_options options;
  engram_options_init(&options);
  options.threads = 1;
  for (int changes = input.choice(4); changes > 0; --changes) {
    std::int32_t* const numbers[] = {
        &options.num_envs,         &options.threads,    &options.chunk,
        &options.substeps,         &options.obs_mode,   &options.reward_mode,
        &options.auto_reset,       &options.freeze_cue, &options.terminate_on_success,
        &options.rotation_sign,    &options.sleep,      &options.image_width,
        &options.image_height,     &options.shadows,    &options.antialias,
        &options.render_shadows,   &options.after_end,  &options.terminate_on_failure,
        &options.max_episode_steps};
    const int which = input.choice(std::size(numbers) + 8);
    if (which < static_cast<int>(std::size(numbers))) {
      *numbers[which] = number(input);
      // Neither this machine's memory nor its threads are what is tested here.
      if (options.num_envs > 64 && options.num_envs <= 1'000'000) options.num_envs = 64;
      if (options.threads > 8 && options.threads <= 1024) options.threads = 8;
      if (options.image_width > 64 && options.image_width <= 4096) options.image_width = 64;
      if (options.image_height > 64 && options.image_height <= 4096) options.image_height = 64;
      continue;
    }
    switch (which - static_cast<int>(std::size(numbers))) {
      case 0:
        options.struct_size = input.take<std::uint8_t>();
        break;
      case 1:
        options.control_mode = name(input, run.texts);
        break;
      case 2:
        options.robot_init_qpos_noise = real(input);
        break;
      case 3:
        for (double& value : values) value = real(input);
        for (engram_pin& pin : pins) {
          pin = {name(input, run.texts), input.choice(4) == 0 ? nullptr : values.data(),
                 static_cast<std::size_t>(input.choice(9))};
        }
        options.pins = input.choice(8) == 0 ? nullptr : pins.data();
        options.num_pins = static_cast<std::size_t>(input.choice(3));
        break;
      case 4:
        choice = {name(input, run.texts), real(input)};
        options.task_options = input.choice(8) == 0 ? nullptr : &choice;
        options.num_task_options = static_cast<std::size_t>(input.choice(2));
        break;
      case 5:
        perturbation = {name(input, run.texts), real(input)};
        options.perturbations = input.choice(8) == 0 ? nullptr : &perturbation;
        options.num_perturbations = static_cast<std::size_t>(input.choice(2));
        break;
      case 6:
        for (const char*& camera : cameras) camera = name(input, run.texts);
        options.cameras = input.choice(8) == 0 ? nullptr : cameras.data();
        options.num_cameras = static_cast<std::size_t>(input.choice(4));
        break;
      default:
        options.renderer = name(input, run.texts);
    }
  }
  return options;
}

void make(Run& run) {
  std::array<engram_pin, 2> pins{};
  std::array<double, 8> values{};
  engram_task_option choice{};
  engram_perturbation perturbation{};
  std::array<const char*, 3> cameras{};
  const engram_options options = any_options(run, pins, values, choice, perturbation, cameras);
  const char* id = name(run.input, run.texts);
  engram_env* env = nullptr;
  const int form = run.input.choice(8);
  // One success per execution is enough, and so are a few failures: both take long.
  if ((!run.made.empty() && form > 1) || ++run.attempts > 4) return;
  const engram_status status =
      checked(engram_make(id, form == 7 ? nullptr : &options, form == 0 ? nullptr : &env));
  require((status == ENGRAM_OK) == (env != nullptr), "a handle without success, or none with it");
  if (env != nullptr) run.made.push_back(env);
}

void close(Run& run) {
  if (run.made.empty()) {
    engram_close(nullptr);
    return;
  }
  engram_close(run.made.back());
  run.made.pop_back();
}

// --- running ---

void reset(Run& run) {
  engram_env* env = run.env();
  Input& input = run.input;
  std::array<std::uint8_t, 64> mask{};
  std::array<std::uint64_t, 64> seeds{};
  std::array<double, 8> values{};
  for (double& value : values) value = real(input);
  const engram_pin pin = {name(input, run.texts), values.data(),
                          static_cast<std::size_t>(input.choice(9))};
  mask[0] = input.take<std::uint8_t>();
  mask[1] = input.take<std::uint8_t>();
  seeds[0] = input.take<std::uint64_t>();
  engram_reset_request request{};
  const int form = input.choice(16);
  if ((form & 1) != 0) request.mask = mask.data();
  if ((form & 2) != 0) request.seeds = seeds.data();
  request.has_pins = (form & 4) != 0 ? 1 : 0;
  request.pins = (form & 8) != 0 ? &pin : nullptr;
  request.num_pins = static_cast<std::size_t>(input.choice(2));
  if (env != nullptr && engram_num_envs(env) > 64) return;
  checked(engram_reset(env, form == 0 ? nullptr : &request));
}

void step(Run& run) {
  engram_env* env = run.env();
  const std::vector<float> actions = run.actions(env);
  const bool null = run.input.choice(16) == 0;
  checked(engram_step(env, null ? nullptr : actions.data(), actions.size()));
}

void step_async(Run& run) {
  engram_env* env = run.env();
  const std::vector<float> actions = run.actions(env);
  checked(engram_step_async(env, actions.data(), actions.size()));
}

void step_wait(Run& run) { checked(engram_step_wait(run.env())); }

void act(Run& run) {
  engram_env* env = run.env();
  std::vector<float> actions = run.actions(env);
  checked(engram_act(env, number(run.input), actions.data(), actions.size()));
}

// --- looking ---

void output(Run& run) {
  engram_env* env = run.env();
  engram_array array{};
  const int form = run.input.choice(8);
  const char* which = name(run.input, run.texts);
  engram_status status = ENGRAM_OK;
  if (form < 3) status = checked(engram_output(env, which, form == 0 ? nullptr : &array));
  if (form >= 3 && form < 6) status = checked(engram_final_output(env, which, &array));
  if (form >= 6) {
    const auto index = static_cast<std::size_t>(number(run.input));
    status = checked(engram_output_at(env, index, &array));
    (void)engram_num_outputs(env);
  }
  if (status == ENGRAM_OK && array.data != nullptr && array.shape[0] > 0) {
    require(array.ndim >= 1 && array.ndim <= 4, "dimensions");
    if (array.ndim == 1 || array.shape[1] > 0) {
      volatile std::uint8_t first = *static_cast<const std::uint8_t*>(array.data);
      (void)first;
    }
  }
}

void facts(Run& run) {
  engram_env* env = run.env();
  (void)engram_num_threads(env);
  (void)engram_state_dim(env);
  (void)engram_horizon(env);
  (void)engram_action_low(env);
  (void)engram_action_high(env);
  (void)engram_unstable_count(env);
  (void)engram_task_id(static_cast<std::size_t>(number(run.input)));
  if (run.input.choice(16) == 0) (void)engram_describe_json(env);
}

void instruction(Run& run) {
  engram_env* env = run.env();
  std::array<char, 256> text{};
  std::size_t length = 0;
  const auto capacity = static_cast<std::size_t>(run.input.take<std::uint8_t>());
  const int form = run.input.choice(8);
  checked(engram_instruction(env, number(run.input), form == 0 ? nullptr : text.data(), capacity,
                             form == 1 ? nullptr : &length));
}

void render(Run& run) {
  engram_env* env = run.env();
  std::vector<std::uint8_t> rgb(3 * 8 * 7);
  const int form = run.input.choice(8);
  const std::int32_t width = form == 0 ? number(run.input) : 8;
  const std::int32_t height = form == 1 ? number(run.input) : 7;
  checked(engram_render(env, number(run.input), name(run.input, run.texts), width, height,
                        form == 2 ? nullptr : rgb.data(), rgb.size()));
}

// --- snapshots ---

void save(Run& run) {
  engram_env* env = run.env();
  const std::int32_t index = number(run.input);
  std::size_t size = 0;
  const int form = run.input.choice(8);
  if (checked(engram_save(env, index, nullptr, 0, form == 0 ? nullptr : &size)) != ENGRAM_OK)
    return;
  if (form == 1) size /= 2;
  std::vector<std::uint8_t> bytes(size);
  if (checked(engram_save(env, index, bytes.data(), bytes.size(), &size)) == ENGRAM_OK) {
    run.snapshot = bytes;
  }
}

void restore(Run& run) {
  engram_env* env = run.env();
  const std::int32_t index = number(run.input);
  if (run.input.choice(4) == 0 && !run.snapshot.empty()) {
    run.snapshot[run.input.take<std::uint16_t>() % run.snapshot.size()] ^= 1;
  }
  const bool null = run.input.choice(16) == 0;
  checked(engram_restore(env, index, null ? nullptr : run.snapshot.data(), run.snapshot.size()));
}

// --- evaluation ---

int answer(void* user, const engram_policy_request* request, engram_policy_reply* reply) {
  Run& run = *static_cast<Run*>(user);
  const std::array<float, 32> actions{};
  // Length by the given shape.
  const std::array<std::int64_t, 3> shape = {1, std::min(number(run.input), 4), 7};
  const int form = run.input.choice(8);
  checked(engram_policy_set(form == 0 ? nullptr : reply, number(run.input),
                            form == 1 ? nullptr : actions.data(), shape.data() + 1, 2));
  checked(engram_policy_set(reply, request->count - 1, actions.data(), shape.data() + 2, 1));
  checked(engram_policy_fail(reply, form == 2 ? nullptr : "enough"));
  checked(engram_policy_identify(reply, form == 3 ? nullptr : form == 4 ? "[]" : "{}"));
  return 1;  // an evaluation to its end takes long
}

void evaluate(Run& run) {
  Input& input = run.input;
  engram_evaluation_options options;
  engram_evaluation_options_init(&options);
  const std::array<const char*, 2> ids = {name(input, run.texts), kNames[0]};
  engram_task_option choice = {name(input, run.texts), real(input)};
  options.ids = ids.data();
  options.num_ids = static_cast<std::size_t>(input.choice(3));
  options.obs_mode = ENGRAM_OBS_STATE;
  options.episodes = 1;
  options.num_envs = 1;
  options.threads = 1;
  const std::string config = input.text();
  const int form = input.choice(16);
  if (form == 0) options.ids = nullptr;
  if (form == 1) options.episodes = number(input);
  if (form == 2) options.num_envs = number(input);
  if (form == 3) options.obs_mode = number(input);
  if (form == 4) options.config_json = config.c_str();
  if (form == 5) options.name = config.c_str();
  if (form == 6) options.renderer = config.c_str();
  if (form >= 7 && form < 9) options.task_options = &choice;
  if (form >= 8 && form < 10) options.num_task_options = 1;
  if (form == 10) options.struct_size = input.take<std::uint8_t>();
  if (form == 11) options.threads = -1;
  if (form == 12) options.resume = "/dev/null/nowhere";
  if (form == 13) options.output = "/dev/null/nowhere";
  if (options.num_envs > 4 || options.episodes > 1'000'000) return;
  char* document = nullptr;
  const bool null = form == 14;
  require(checked(engram_evaluate(null ? nullptr : &options, answer, &run,
                                  form == 15 ? nullptr : &document)) != ENGRAM_OK,
          "an evaluation without an answer");
  require(document == nullptr, "a document of a failed evaluation");
  engram_free_text(document);
}

constexpr void (*kCalls[])(Run&) = {step,    step,   reset, step_async,  step_wait,
                                    act,     output, facts, instruction, save,
                                    restore, render, make,  close,       evaluate};

}  // namespace

void fuzz_c_api(Data data) {
  for (Batch& batch : batches()) batch.rewind();
  Run run{Input(data)};
  while (!run.input.empty()) kCalls[run.input.choice(std::size(kCalls))](run);
  while (!run.made.empty()) close(run);
}

}  // namespace engram::fuzz
