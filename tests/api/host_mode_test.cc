// The C API gives the same bytes whatever mode of arithmetic its caller has set.
#include "tests/host_mode.h"

#if defined(__SSE__)  // modes are set by hand here

#include <functional>
#include <nlohmann/json.hpp>
#include <span>

#include "engram/engram_task.h"
#include "tests/api/c_api_fixture.h"

namespace engram {
namespace {

using test::Host, test::HostMode;
using Bytes = std::vector<std::byte>;

// Calls of a program in one mode, and all that they have given.
class Program {
 public:
  explicit Program(const HostMode& mode) : host_(mode) {}

  // f: returns a status, and writes to arrays that are noted afterwards.
  template <class F>
  void call(const F& f) {
    engram_status status = ENGRAM_INTERNAL;
    host_.run([&] { status = f(); });
    INFO(engram_last_error());
    REQUIRE(status == ENGRAM_OK);
  }
  template <class T>
  void note(const std::vector<T>& values) {
    const auto bytes = std::as_bytes(std::span(values));
    given_.insert(given_.end(), bytes.begin(), bytes.end());
  }
  void note(const std::string& text) { note(std::vector<char>(text.begin(), text.end())); }
  // f: copies a text, as engram_instruction does.
  template <class F>
  void note_text(const F& f) {
    std::vector<char> text(4000);
    std::size_t length = 0;
    call([&] { return f(text.data(), text.size(), &length); });
    note(text);
  }
  // f: makes a text that its caller frees.
  template <class F>
  std::string note_document(const F& f) {
    char* made = nullptr;
    call([&] { return f(&made); });
    const std::string text(made);
    engram_free_text(made);
    note(text);
    return text;
  }

  const Bytes& given() const { return given_; }
  int changed() const { return host_.changed(); }

 private:
  Host host_;
  Bytes given_;
};

// Everything that a running batch tells when asked.
void ask_all(Program& program, engram_env* env) {
  const auto n = static_cast<std::size_t>(engram_num_envs(env));
  for (std::int32_t i = 0; i < engram_num_envs(env); ++i) {
    program.note_text([&](char* text, std::size_t capacity, std::size_t* length) {
      return engram_instruction(env, i, text, capacity, length);
    });
    program.note_text([&](char* text, std::size_t capacity, std::size_t* length) {
      return engram_words(env, i, text, capacity, length);
    });
  }
  std::vector<std::uint8_t> image(std::size_t{24} * 20 * 3);
  program.call(
      [&] { return engram_render(env, 0, "render_camera", 24, 20, image.data(), image.size()); });
  program.note(image);
  std::vector<float> qpos(9 * n);
  std::vector<float> qvel(9 * n);
  std::vector<float> pose(7 * n);
  program.call([&] { return engram_robot_state(env, qpos.data(), qvel.data(), pose.data()); });
  std::vector<float> extrinsic(12 * n);
  std::vector<float> to_world(16 * n);
  std::vector<float> intrinsic(9 * n);
  program.call([&] {
    return engram_camera_params(env, "base_camera", 30, 30, extrinsic.data(), to_world.data(),
                                intrinsic.data());
  });
  std::vector<float> drawn(n * static_cast<std::size_t>(engram_drawn_dim(env)));
  program.call([&] { return engram_drawn(env, drawn.data(), drawn.size()); });
  for (const auto& values : {qpos, qvel, pose, extrinsic, to_world, intrinsic, drawn}) {
    program.note(values);
  }
}

void note_outputs(Program& program, engram_env* env) {
  for (std::size_t i = 0; i < engram_num_outputs(env); ++i) {
    engram_array array{};
    program.call([&] { return engram_output_at(env, i, &array); });
    program.note(test::bytes_of(array));
    if (engram_final_output(env, array.name, &array) == ENGRAM_OK) {
      program.note(test::bytes_of(array));
    }
  }
}

// A batch from its making to its restoration.
void play(Program& program, const char* id, engram_options options) {
  engram_env* env = nullptr;
  program.call([&] { return engram_make(id, &options, &env); });
  const test::BatchHandle batch(env);
  program.note_document([&](char** text) { return engram_describe_task_json(id, &options, text); });
  program.call([&] { return engram_reset(env, nullptr); });
  note_outputs(program, env);
  ask_all(program, env);
  std::size_t size = 0;
  program.call([&] { return engram_save(env, ENGRAM_WHOLE_BATCH, nullptr, 0, &size); });
  Bytes saved(size);
  program.call(
      [&] { return engram_save(env, ENGRAM_WHOLE_BATCH, saved.data(), saved.size(), &size); });
  std::vector<float> actions(test::action_count(batch));
  const auto act = [&](engram_policy policy) {
    program.call([&] { return engram_act(env, policy, actions.data(), actions.size()); });
    program.note(actions);
  };
  act(ENGRAM_POLICY_ORACLE);
  program.call([&] { return engram_step(env, actions.data(), actions.size()); });
  act(ENGRAM_POLICY_RANDOM);
  program.call([&] { return engram_step_async(env, actions.data(), actions.size()); });
  program.call([&] { return engram_step_wait(env); });
  act(ENGRAM_POLICY_BLIND);
  program.call([&] { return engram_step_no_action(env); });
  note_outputs(program, env);
  ask_all(program, env);
  program.note(saved);
  program.call([&] { return engram_restore(env, ENGRAM_WHOLE_BATCH, saved.data(), size); });
  note_outputs(program, env);
  program.note(std::string(engram_describe_json(env)));
}

// A question and the answer to it.
void answer(Program& program) {
  engram_options options = test::default_options(1);
  options.auto_reset = ENGRAM_AUTO_RESET_OFF;
  const test::BatchHandle batch = test::make_running(options);
  engram_env* const env = batch.get();
  program.call([&] { return engram_ask(env, 0); });
  std::vector<float> actions(test::action_count(batch));
  for (int step = 0; step < engram_horizon(env); ++step) {
    std::vector<char> question(4000);
    program.call(
        [&] { return engram_question(env, 0, question.data(), question.size(), nullptr); });
    if (nlohmann::json::parse(question.data())["due"].get<bool>()) {
      program.note(question);
      const std::int32_t choice = 1;
      program.call([&] { return engram_answer(env, 0, &choice, 1); });
    }
    program.call(
        [&] { return engram_act(env, ENGRAM_POLICY_BLIND, actions.data(), actions.size()); });
    program.call([&] { return engram_step(env, actions.data(), actions.size()); });
    program.note(actions);
  }
}

int still(void* /*user*/, const engram_policy_request* request, engram_policy_reply* reply) {
  const std::vector<float> zeros(7, 0.0F);
  const std::int64_t shape[] = {1, 7};
  for (std::int32_t row = 0; row < request->count; ++row) {
    if (engram_policy_set(reply, row, zeros.data(), shape, 2) != ENGRAM_OK) return 1;
  }
  return 0;
}

// Results of an evaluation, and what is made of them.
void evaluate(Program& program) {
  engram_evaluation_options options = test::evaluation_options(3);
  options.threads = 2;
  const std::string results = program.note_document(
      [&](char** text) { return engram_evaluate(&options, still, nullptr, text); });
  program.note_document([&](char** text) {
    return engram_compare(results.c_str(), results.c_str(), nullptr, 0, text);
  });
  program.note_document([&](char** text) { return engram_report(results.c_str(), "md", text); });
}

// What scripted policies are built on.
void compute(Program& program) {
  const std::vector<double> points = {0.4, 0.1, 0.3, 0.5, -0.2, 0.1};
  const std::vector<double> goals = {0.55, -0.1, 0.05, 0.45, 0.2, 0.02};
  const std::vector<double> turns = {0, 1, 0, 0, 0.1, 0.9, 0.2, 0.1};
  const std::vector<double> grippers = {1, -1};
  std::vector<float> actions(14);
  program.call([&] {
    return engram_servo_tcp(2, points.data(), turns.data(), goals.data(), turns.data(),
                            grippers.data(), actions.data());
  });
  program.note(actions);
  std::vector<double> waypoints(6);
  program.call([&] {
    return engram_approach_from_above(2, points.data(), goals.data(), 0.1, waypoints.data());
  });
  program.note(waypoints);
  program.call(
      [&] { return engram_descend(2, points.data(), goals.data(), 0.2, waypoints.data()); });
  program.note(waypoints);
  std::vector<double> tilted(8);
  program.call([&] {
    return engram_tilt_outwards(2, turns.data(), points.data(), 0.3, 0.7, 0.5, tilted.data());
  });
  program.note(tilted);
  const std::vector<std::uint64_t> keys = {3, 1ULL << 60U};
  std::vector<double> numbers(6);
  program.call([&] { return engram_guesses(2, keys.data(), keys.data(), 3, numbers.data()); });
  program.note(numbers);
  const std::vector<double> x = {0.1, 0.3, 0.7, 0.9};
  for (const char* name : {"sin", "cos", "tan", "exp", "log", "asin", "tanh", "atan2", "hypot"}) {
    const bool two = std::string(name) == "atan2" || std::string(name) == "hypot";
    std::vector<double> values(x.size());
    program.call([&] {
      return engram_real_function(name, x.size(), x.data(), two ? x.data() : nullptr,
                                  values.data());
    });
    program.note(values);
  }
}

// Plays in each of the modes and compares with the default one.
void check_modes(std::span<const HostMode> modes, const std::function<void(Program&)>& run) {
  Program usual{HostMode()};
  run(usual);
  REQUIRE(usual.given().size() > 500);
  for (const HostMode& mode : modes) {
    CAPTURE(mode.sse, mode.x87);
    Program program(mode);
    run(program);
    CHECK((program.given() == usual.given()));
    CHECK(program.changed() == 0);
  }
}

engram_options images_of(int num_envs) {
  engram_options options = test::default_options(num_envs);
  options.obs_mode = ENGRAM_OBS_RGB;
  options.image_width = 24;
  options.image_height = 24;
  return options;
}

TEST_CASE("C API: a batch gives the same bytes in every mode of its caller",
          "[c_api][determinism]") {
  check_modes(test::host_modes(), [](Program& program) {
    play(program, "RotateLenientPos-VLA-v0", images_of(2));
    engram_options options = test::default_options(2);
    options.constants = R"({"CUBE_HALFSIZE": 0.0213})";
    play(program, test::kId, options);
  });
}

TEST_CASE("C API: what is computed is the same in every mode of its caller",
          "[c_api][determinism]") {
  check_modes(test::host_modes(), compute);
}

TEST_CASE("C API: answers and results are the same in every mode of their caller",
          "[c_api][determinism]") {
  const std::vector<HostMode> modes = test::host_modes();
  const HostMode some[] = {modes[12], modes[25], modes[39]};
  const auto run = [](Program& program) {
    answer(program);
    evaluate(program);
  };
  check_modes(some, run);
}

TEST_CASE("C API: ten tasks give the same bytes in all modes of their caller",
          "[c_api][determinism][long]") {
  for (const char* id :
       {"RememberColor9-VLA-v0", "RememberShape3-VLA-v0", "FindImposterColor3-VLA-v0",
        "ShellGamePick-VLA-v0", "ChainOfColors3-VLA-v0", "InterceptGrabFast-VLA-v0",
        "RotateStrictPos-VLA-v0", "TraceShapeMedium-VLA-v0", "BatteriesCheckerEasy-3-VLA-v0",
        "TimedTransferEasy-VLA-v0"}) {
    CAPTURE(id);
    check_modes(test::host_modes(), [&](Program& program) { play(program, id, images_of(4)); });
  }
}

}  // namespace
}  // namespace engram

#endif
