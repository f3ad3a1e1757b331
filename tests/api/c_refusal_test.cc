// Refusals of the plain C API, and their messages.
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "tests/api/c_api_fixture.h"

namespace engram {
namespace {

using test::BatchHandle, test::check_refused, test::default_options, test::kId, test::make_batch,
    test::make_running;

// A change of the options, and a part of the message about it.
struct BadOption {
  std::function<void(engram_options&)> change;
  engram_status status;
  const char* part;
};

constexpr double kValues[] = {0.5, 1};
constexpr engram_pin kNameless = {nullptr, kValues, 1};
constexpr engram_pin kEmpty = {"target", nullptr, 1};
constexpr engram_pin kFraction = {"target", kValues, 1};
constexpr engram_pin kHuge = {"target", kValues, std::numeric_limits<std::size_t>::max()};
constexpr engram_pin kUnknown = {"colour", kValues, 1};
constexpr engram_task_option kNamelessOption = {nullptr, 1};
constexpr engram_task_option kUnknownOption = {"gravity", 1};
constexpr engram_perturbation kNamelessAxis = {nullptr, 1};
constexpr engram_perturbation kUnknownAxis = {"smell", 1};
constexpr engram_perturbation kBeyond = {"blur", 1.5};
constexpr const char* kNoCamera[] = {nullptr};
constexpr const char* kOtherCamera[] = {"top_camera"};

const std::vector<BadOption>& bad_options() {
  using O = engram_options;
  static const std::vector<BadOption> bad = {
      {[](O& o) { o.struct_size = 0; }, ENGRAM_INVALID_ARGUMENT, "engram_options_init"},
      {[](O& o) { o.struct_size += 8; }, ENGRAM_INVALID_ARGUMENT, "struct_size"},
      {[](O& o) { o.num_envs = 0; }, ENGRAM_INVALID_ARGUMENT, "num_envs: 0 given"},
      {[](O& o) { o.num_envs = -5; }, ENGRAM_INVALID_ARGUMENT, "1 to 1000000"},
      {[](O& o) { o.threads = 1025; }, ENGRAM_INVALID_ARGUMENT, "threads: 1025 given"},
      {[](O& o) { o.chunk = -1; }, ENGRAM_INVALID_ARGUMENT, "chunk"},
      {[](O& o) { o.substeps = 1001; }, ENGRAM_INVALID_ARGUMENT, "substeps"},
      {[](O& o) { o.obs_mode = 17; }, ENGRAM_INVALID_ARGUMENT, "obs_mode: 17 given, 0 to 16"},
      {[](O& o) { o.obs_mode = -1; }, ENGRAM_INVALID_ARGUMENT, "obs_mode: -1 given"},
      {[](O& o) { o.reward_mode = 17; }, ENGRAM_INVALID_ARGUMENT, "reward_mode: 17"},
      {[](O& o) { o.rules = 2; }, ENGRAM_INVALID_ARGUMENT, "rules: 2 given, 0 to 1 allowed"},
      {[](O& o) { o.auto_reset = 3; }, ENGRAM_INVALID_ARGUMENT, "auto_reset: 3 given, 0 to 2"},
      {[](O& o) { o.after_end = 3; }, ENGRAM_INVALID_ARGUMENT, "after_end: 3 given, 0 to 2"},
      {[](O& o) { o.after_end = ENGRAM_AFTER_END_CONTINUE; }, ENGRAM_INVALID_ARGUMENT,
       "off needed"},
      {[](O& o) { o.terminate_on_failure = -1; }, ENGRAM_INVALID_ARGUMENT, "0 or 1"},
      {[](O& o) { o.max_episode_steps = -1; }, ENGRAM_INVALID_ARGUMENT,
       "steps: -1 given, 0 (unset)"},
      {[](O& o) { o.max_episode_steps = 1'000'001; }, ENGRAM_INVALID_ARGUMENT, "to 1000000"},
      {[](O& o) { o.control_mode = "pd"; }, ENGRAM_UNKNOWN_ID, "'pd'; allowed are: pd_joint"},
      {[](O& o) { o.rotation_sign = 0; }, ENGRAM_INVALID_ARGUMENT, "rotation_sign"},
      {[](O& o) { o.freeze_cue = 2; }, ENGRAM_INVALID_ARGUMENT, "freeze_cue: 2 given, 0 or 1"},
      {[](O& o) { o.terminate_on_success = 2; }, ENGRAM_INVALID_ARGUMENT, "-1, 0 or 1"},
      {[](O& o) { o.sleep = -1; }, ENGRAM_INVALID_ARGUMENT, "sleep: -1"},
      {[](O& o) { o.robot_init_qpos_noise = NAN; }, ENGRAM_INVALID_ARGUMENT, "qpos_noise"},
      {[](O& o) { o.num_pins = 1; }, ENGRAM_INVALID_ARGUMENT, "pins: NULL given"},
      {[](O& o) { o.pins = &kNameless, o.num_pins = 1; }, ENGRAM_INVALID_ARGUMENT, "NULL given"},
      {[](O& o) { o.pins = &kEmpty, o.num_pins = 1; }, ENGRAM_INVALID_ARGUMENT, "NULL given"},
      {[](O& o) { o.pins = &kFraction, o.num_pins = 1; }, ENGRAM_INVALID_ARGUMENT, "whole number"},
      {[](O& o) { o.pins = &kHuge, o.num_pins = 1; }, ENGRAM_INVALID_ARGUMENT, "pin 'target'"},
      {[](O& o) { o.pins = &kUnknown, o.num_pins = 1; }, ENGRAM_UNKNOWN_ID, "'colour'"},
      {[](O& o) { o.num_task_options = 2; }, ENGRAM_INVALID_ARGUMENT, "task_options: NULL"},
      {[](O& o) { o.task_options = &kNamelessOption, o.num_task_options = 1; },
       ENGRAM_INVALID_ARGUMENT, "name of a task option: NULL"},
      {[](O& o) { o.task_options = &kUnknownOption, o.num_task_options = 1; }, ENGRAM_UNKNOWN_ID,
       "gravity"},
      {[](O& o) { o.num_perturbations = 1; }, ENGRAM_INVALID_ARGUMENT, "perturbations: NULL"},
      {[](O& o) { o.perturbations = &kNamelessAxis, o.num_perturbations = 1; },
       ENGRAM_INVALID_ARGUMENT, "axis of a perturbation: NULL"},
      {[](O& o) { o.perturbations = &kUnknownAxis, o.num_perturbations = 1; }, ENGRAM_UNKNOWN_ID,
       "no axis of perturbations named 'smell'; allowed are: camera"},
      {[](O& o) { o.perturbations = &kBeyond, o.num_perturbations = 1; }, ENGRAM_INVALID_ARGUMENT,
       "perturbation 'blur': level 1.5 given, 0 to 1 allowed"},
      {[](O& o) { o.obs_mode = ENGRAM_OBS_RGB, o.image_width = 0; }, ENGRAM_INVALID_ARGUMENT,
       "0 x 128"},
      {[](O& o) { o.obs_mode = ENGRAM_OBS_RGB, o.num_cameras = 1; }, ENGRAM_INVALID_ARGUMENT,
       "cameras: NULL"},
      {[](O& o) { o.obs_mode = ENGRAM_OBS_RGB, o.cameras = kNoCamera, o.num_cameras = 1; },
       ENGRAM_INVALID_ARGUMENT, "name of a camera: NULL"},
      {[](O& o) { o.obs_mode = ENGRAM_OBS_RGB, o.cameras = kOtherCamera, o.num_cameras = 1; },
       ENGRAM_UNKNOWN_ID, "top_camera"},
      {[](O& o) { o.renderer = nullptr; }, ENGRAM_INVALID_ARGUMENT, "renderer: NULL"},
      {[](O& o) { o.obs_mode = ENGRAM_OBS_RGB, o.renderer = "ray"; }, ENGRAM_INVALID_ARGUMENT,
       "ray"},
      {[](O& o) { o.shadows = 5; }, ENGRAM_INVALID_ARGUMENT, "shadows: 5"},
      {[](O& o) { o.antialias = 5; }, ENGRAM_INVALID_ARGUMENT, "antialias: 5"},
      {[](O& o) { o.render_shadows = 5; }, ENGRAM_INVALID_ARGUMENT, "render_shadows: 5"},
  };
  return bad;
}

TEST_CASE("Every bad option is refused with what was given and what is allowed", "[c_api]") {
  for (const BadOption& bad : bad_options()) {
    engram_options options = default_options();
    bad.change(options);
    INFO(bad.part);
    auto* env = reinterpret_cast<engram_env*>(&options);  // anything but NULL
    check_refused(engram_make(kId, &options, &env), bad.status, bad.part);
    CHECK(env == nullptr);
  }
}

TEST_CASE("Making a batch needs an id that exists and somewhere to put it", "[c_api]") {
  engram_env* env = nullptr;
  check_refused(engram_make(nullptr, nullptr, &env), ENGRAM_INVALID_ARGUMENT, "id: NULL");
  check_refused(engram_make(kId, nullptr, nullptr), ENGRAM_INVALID_ARGUMENT, "env: NULL");
  check_refused(engram_make("RememberColor4", nullptr, &env), ENGRAM_UNKNOWN_ID, "did you mean");
  check_refused(engram_make("", nullptr, &env), ENGRAM_UNKNOWN_ID, "no task ''");
  CHECK(env == nullptr);
}

TEST_CASE("No function crashes on a NULL batch", "[c_api]") {
  std::array<float, 7> actions{};
  std::array<std::uint8_t, 12> bytes{};
  std::size_t size = 0;
  engram_array array{};
  engram_env* none = nullptr;
  const std::vector<engram_status> statuses = {
      engram_reset(none, nullptr),
      engram_step(none, actions.data(), 7),
      engram_step_no_action(none),
      engram_step_async(none, actions.data(), 7),
      engram_step_wait(none),
      engram_act(none, ENGRAM_POLICY_ZERO, actions.data(), 7),
      engram_output(none, "reward", &array),
      engram_final_output(none, "reward", &array),
      engram_output_at(none, 0, &array),
      engram_instruction(none, 0, nullptr, 0, &size),
      engram_words(none, 0, nullptr, 0, &size),
      engram_ask(none, 0),
      engram_question(none, 0, nullptr, 0, &size),
      engram_answer(none, 0, nullptr, 0),
      engram_render(none, 0, "base_camera", 2, 2, bytes.data(), 12),
      engram_save(none, 0, nullptr, 0, &size),
      engram_restore(none, 0, bytes.data(), 12),
  };
  for (const engram_status status : statuses) CHECK(status == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_num_envs(none) == 0);
  CHECK(engram_num_threads(none) == 0);
  CHECK(engram_action_dim(none) == 0);
  CHECK(engram_state_dim(none) == 0);
  CHECK(engram_horizon(none) == 0);
  CHECK(engram_num_outputs(none) == 0);
  CHECK(engram_unstable_count(none) == 0);
  CHECK(engram_action_low(none) == nullptr);
  CHECK(engram_action_high(none) == nullptr);
  CHECK(engram_describe_json(none) == nullptr);
  CHECK_THAT(engram_last_error(), Catch::Matchers::Contains("env: NULL"));
  engram_options_init(nullptr);
  engram_close(nullptr);
}

TEST_CASE("No function crashes on a NULL buffer", "[c_api]") {
  const BatchHandle batch = make_running(1);
  engram_env* env = batch.get();
  engram_array array{};
  std::size_t size = 0;
  const std::vector<engram_status> statuses = {
      engram_step(env, nullptr, 7),
      engram_step_async(env, nullptr, 7),
      engram_act(env, ENGRAM_POLICY_ZERO, nullptr, 7),
      engram_output(env, nullptr, &array),
      engram_output(env, "reward", nullptr),
      engram_final_output(env, nullptr, &array),
      engram_final_output(env, "reward", nullptr),
      engram_output_at(env, 0, nullptr),
      engram_instruction(env, 0, nullptr, 5, &size),
      engram_words(env, 0, nullptr, 5, &size),
      engram_question(env, 0, nullptr, 5, &size),
      engram_answer(env, 0, nullptr, 1),
      engram_render(env, 0, nullptr, 2, 2, nullptr, 12),
      engram_render(env, 0, "base_camera", 2, 2, nullptr, 12),
      engram_save(env, 0, nullptr, 5, &size),
      engram_save(env, 0, nullptr, 0, nullptr),
      engram_restore(env, 0, nullptr, 5),
  };
  for (const engram_status status : statuses) CHECK(status == ENGRAM_INVALID_ARGUMENT);
  engram_reset_request request{};
  request.has_pins = 1;
  request.num_pins = 3;
  check_refused(engram_reset(env, &request), ENGRAM_INVALID_ARGUMENT, "pins: NULL");
}

TEST_CASE("C: nothing runs before the first reset", "[c_api]") {
  const BatchHandle batch = make_batch(1);
  engram_env* env = batch.get();
  std::array<float, 7> actions{};
  std::array<std::uint8_t, 12> image{};
  std::size_t size = 0;
  const auto refused = [](engram_status status) {
    check_refused(status, ENGRAM_BAD_STATE, "reset first");
  };
  refused(engram_step(env, actions.data(), 7));
  refused(engram_step_async(env, actions.data(), 7));
  refused(engram_act(env, ENGRAM_POLICY_ZERO, actions.data(), 7));
  refused(engram_save(env, ENGRAM_WHOLE_BATCH, nullptr, 0, &size));
  refused(engram_render(env, 0, "base_camera", 2, 2, image.data(), 12));
  check_refused(engram_step_wait(env), ENGRAM_BAD_STATE, "no step is under way");
}

TEST_CASE("Wrong actions, indices, names and sizes are refused and change nothing", "[c_api]") {
  const BatchHandle batch = make_running(2);
  engram_env* env = batch.get();
  const std::vector<std::byte> before = test::outputs_of(batch);
  std::vector<float> actions(14);
  check_refused(engram_step(env, actions.data(), 13), ENGRAM_INVALID_ARGUMENT, "14 needed");
  check_refused(engram_act(env, ENGRAM_POLICY_ZERO, actions.data(), 15), ENGRAM_INVALID_ARGUMENT,
                "14 needed");
  check_refused(engram_act(env, 5, actions.data(), 14), ENGRAM_INVALID_ARGUMENT, "policy: 5");
  check_refused(engram_act(env, -1, actions.data(), 14), ENGRAM_INVALID_ARGUMENT, "policy: -1");
  actions[9] = std::numeric_limits<float>::infinity();
  check_refused(engram_step(env, actions.data(), 14), ENGRAM_INVALID_ARGUMENT,
                "environment 1, component 2");

  engram_array array{};
  check_refused(engram_output(env, "rewards", &array), ENGRAM_UNKNOWN_ID, "reward, terminated");
  check_refused(engram_output(env, "rgb", &array), ENGRAM_UNKNOWN_ID, "'rgb'");
  check_refused(engram_final_output(env, "reward", &array), ENGRAM_BAD_STATE, "same-step");
  check_refused(engram_output_at(env, engram_num_outputs(env), &array), ENGRAM_INVALID_ARGUMENT,
                "output");
  const std::size_t tasks = engram_num_tasks();
  CHECK(engram_task_id(tasks) == nullptr);
  CHECK_THAT(engram_last_error(),
             Catch::Matchers::Contains("task " + std::to_string(tasks) + " given, 0 to " +
                                       std::to_string(tasks - 1)));

  std::array<std::uint8_t, 12> image{};
  char text[4];
  const auto bad = ENGRAM_INVALID_ARGUMENT;
  check_refused(engram_instruction(env, 2, text, 4, nullptr), bad, "0 to 1 allowed");
  check_refused(engram_render(env, -1, "base_camera", 2, 2, image.data(), 12), bad, "0 to 1");
  check_refused(engram_render(env, 0, "base_camera", 2, 2, image.data(), 11), bad, "12 needed");
  check_refused(engram_render(env, 0, "base_camera", 0, 2, image.data(), 12), bad, "4096");
  check_refused(engram_render(env, 0, "base", 2, 2, image.data(), 12), ENGRAM_UNKNOWN_ID,
                "base_camera");
  CHECK(test::outputs_of(batch) == before);
}

}  // namespace
}  // namespace engram
