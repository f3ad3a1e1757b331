// Running batches through the plain C API: the same bits as the engine, whole or in two halves.
#include <atomic>
#include <limits>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/batch/scripted_policy.h"
#include "protocol/make/make.h"
#include "tests/allocation_counter.h"
#include "tests/api/c_api_fixture.h"
#include "tests/env_helpers.h"
#include "tests/sanitizers.h"

namespace engram {
namespace {

using test::actions_of, test::BatchHandle, test::bytes_of, test::check_refused,
    test::default_options, test::kId, test::make_batch, test::make_running, test::output,
    test::outputs_of, test::step_by, test::values;

engram_options same_step(int num_envs) {
  engram_options options = default_options(num_envs);
  options.auto_reset = ENGRAM_AUTO_RESET_SAME_STEP;
  return options;
}

TEST_CASE("Numbers that change while a step runs are those that it has checked", "[c_api]") {
  const BatchHandle batch = make_running(same_step(64));
  const std::size_t count = test::action_count(batch);
  // Another thread writes to the actions all the time.
  std::vector<std::atomic<float>> actions(count);
  static_assert(sizeof(std::atomic<float>) == sizeof(float));
  test::allow_races(actions.data(), count * sizeof(float));
  std::atomic<bool> done = false;
  std::thread writer([&] {
    while (!done) {
      for (const float value : {0.0F, std::numeric_limits<float>::quiet_NaN()}) {
        actions[count - 1] = value;
      }
    }
  });
  int taken = 0;
  // Refused steps take microseconds: all of some thousand may see one NaN while the writer waits.
  for (int i = 0; i < 2000 || taken < 10; ++i) {
    const auto* plain = reinterpret_cast<const float*>(actions.data());
    taken += engram_step(batch.get(), plain, count) == ENGRAM_OK ? 1 : 0;
  }
  done = true;
  writer.join();
  CHECK(engram_unstable_count(batch.get()) == 0);
}

TEST_CASE("Outputs are the engine's bits, step by step and across resets", "[c_api]") {
  const BatchHandle batch = make_running(same_step(6));
  const BatchOptions options{
      .num_envs = 6, .seed = 11, .threads = 1, .auto_reset = AutoReset::kSameStep};
  const std::unique_ptr<Batch> engine = make(kId, options);
  engine->reset();
  std::vector<float> actions(42);
  int ended = 0;
  for (int i = 0; i < 60; ++i) {
    ScriptedPolicy(*engine, Policy::kOracle).act(actions);
    REQUIRE(actions == actions_of(batch, ENGRAM_POLICY_ORACLE));
    engine->step(actions);
    REQUIRE(engram_step(batch.get(), actions.data(), actions.size()) == ENGRAM_OK);
    for (std::size_t field = 0; field < test::columns_of(*engine).size(); ++field) {
      const ColumnView column = test::columns_of(*engine)[field];
      const ColumnView final_column = engine->final_output(column.field->name);
      const engram_array array = output(batch, column.field->name.c_str());
      engram_array final_array{};
      REQUIRE(engram_final_output(batch.get(), array.name, &final_array) == ENGRAM_OK);
      INFO(array.name << " in step " << i);
      CHECK(std::memcmp(array.data, column.data, test::size_of(array)) == 0);
      CHECK(std::memcmp(final_array.data, final_column.data, test::size_of(array)) == 0);
    }
    for (int env = 0; env < 6; ++env)
      ended += values<std::uint8_t>(output(batch, "final_mask"))[env];
  }
  CHECK(ended >= 12);
}

TEST_CASE("Outputs have names, units, types and shapes, and stay where they are", "[c_api]") {
  const BatchHandle batch = make_running(3);
  const engram_array observation = output(batch, "observation");
  CHECK(observation.dtype == ENGRAM_FLOAT32);
  CHECK(observation.ndim == 2);
  CHECK(observation.shape[0] == 3);
  CHECK(observation.shape[1] == engram_state_dim(batch.get()));
  const engram_array proprio = output(batch, "proprio");
  CHECK(proprio.shape[1] == 7);
  CHECK(proprio.unit == std::string("m, rad"));
  CHECK(proprio.description != std::string());
  const engram_array reward = output(batch, "reward");
  CHECK(reward.ndim == 1);
  CHECK(output(batch, "terminated").dtype == ENGRAM_BOOL);
  CHECK(output(batch, "elapsed_steps").dtype == ENGRAM_INT32);
  CHECK(output(batch, "episode_return").dtype == ENGRAM_FLOAT64);
  CHECK(output(batch, "final_mask").shape[0] == 3);
  step_by(batch, ENGRAM_POLICY_RANDOM);
  CHECK(output(batch, "observation").data == observation.data);
  CHECK(engram_action_low(batch.get())[6] == -1);
  CHECK(engram_action_high(batch.get())[6] == 1);
  CHECK(engram_num_threads(batch.get()) == 2);
  CHECK(engram_horizon(batch.get()) == 25);
}

TEST_CASE("Images replace the state, and the last ones of an episode are kept", "[c_api]") {
  engram_options options = same_step(2);
  options.obs_mode = ENGRAM_OBS_RGB;
  options.image_width = 16;
  options.image_height = 12;
  const BatchHandle batch = make_running(options);
  const engram_array rgb = output(batch, "rgb");
  CHECK(rgb.dtype == ENGRAM_UINT8);
  REQUIRE(rgb.ndim == 4);
  CHECK(std::vector<std::int64_t>(rgb.shape, rgb.shape + 4) ==
        std::vector<std::int64_t>{2, 12, 16, 6});
  const engram_array observation = output(batch, "observation");
  CHECK(observation.shape[1] == 0);

  engram_array final_rgb{};
  REQUIRE(engram_final_output(batch.get(), "rgb", &final_rgb) == ENGRAM_OK);
  std::vector<std::uint8_t> image(16 * 12 * 3);
  for (int i = 0; i < 25; ++i) {
    CHECK(values<std::uint8_t>(output(batch, "final_mask"))[0] == 0);
    step_by(batch, ENGRAM_POLICY_ZERO);
  }
  CHECK(values<std::uint8_t>(output(batch, "final_mask"))[0] == 1);
  CHECK(bytes_of(final_rgb) != bytes_of(rgb));  // the cue of a new episode is visible again
  // What a sensor shows of the new episode is what its observation shows.
  REQUIRE(engram_render(batch.get(), 0, "base_camera", 16, 12, image.data(), image.size()) ==
          ENGRAM_OK);
  for (std::size_t pixel = 0; pixel < image.size() / 3; ++pixel) {
    REQUIRE(image[3 * pixel] == values<std::uint8_t>(rgb)[6 * pixel]);
  }
}

TEST_CASE("Depth and segmentation come beside images, and their last ones are kept", "[c_api]") {
  engram_options options = same_step(2);
  options.obs_mode = ENGRAM_OBS_RGB_DEPTH_SEGMENTATION;
  options.image_width = 16;
  options.image_height = 12;
  const BatchHandle batch = make_running(options);
  engram::BatchOptions same{.num_envs = 2,
                            .seed = options.seed,
                            .obs_mode = engram::ObsMode::kRgbDepthSegmentation,
                            .auto_reset = engram::AutoReset::kSameStep};
  same.images.width = 16;
  same.images.height = 12;
  const std::unique_ptr<engram::Batch> engine = engram::make(kId, same);
  engine->reset();
  const auto equal = [](const engram_array& array, std::span<const std::int16_t> cells) {
    return std::ranges::equal(
        std::span(static_cast<const std::int16_t*>(array.data), 2 * 12 * 16 * 2), cells);
  };
  engram_array final_depth{};
  engram_array final_segmentation{};
  REQUIRE(engram_final_output(batch.get(), "depth", &final_depth) == ENGRAM_OK);
  REQUIRE(engram_final_output(batch.get(), "segmentation", &final_segmentation) == ENGRAM_OK);
  for (const char* name : {"depth", "segmentation"}) {
    const engram_array array = output(batch, name);
    CHECK(array.dtype == ENGRAM_INT16);
    REQUIRE(array.ndim == 4);
    CHECK(std::vector<std::int64_t>(array.shape, array.shape + 4) ==
          std::vector<std::int64_t>{2, 12, 16, 2});
  }
  CHECK(output(batch, "depth").unit == std::string("mm"));
  for (int i = 0; i < 26; ++i) {
    REQUIRE(equal(output(batch, "depth"), engine->images().depth));
    REQUIRE(equal(output(batch, "segmentation"), engine->images().segmentation));
    REQUIRE(equal(final_depth, test::final_images(*engine).depth));
    REQUIRE(equal(final_segmentation, test::final_images(*engine).segmentation));
    step_by(batch, ENGRAM_POLICY_ZERO);
    engine->step(std::vector<float>(14));
  }
  CHECK(std::ranges::any_of(test::final_images(*engine).depth,
                            [](std::int16_t value) { return value > 0; }));
  const auto names = nlohmann::json::parse(engram_describe_json(batch.get()))["segmentation_names"];
  CHECK(std::ranges::equal(names.get<std::vector<std::string>>(),
                           engine->images().segmentation_names));
}

TEST_CASE("A reset takes masks, seeds and pins", "[c_api]") {
  const BatchHandle batch = make_running(3);
  const double target = 2;
  const engram_pin pin = {"target", &target, 1};
  const std::uint8_t mask[] = {0, 7, 0};
  const std::uint64_t seeds[] = {1, 2, 3};
  engram_reset_request request{};
  request.mask = mask;
  request.seeds = seeds;
  request.pins = &pin;
  request.num_pins = 1;
  request.has_pins = 1;
  const std::vector<std::byte> before = bytes_of(output(batch, "observation"));
  REQUIRE(engram_reset(batch.get(), &request) == ENGRAM_OK);
  const std::vector<std::byte> after = bytes_of(output(batch, "observation"));
  const std::size_t row = before.size() / 3;
  CHECK(std::memcmp(before.data(), after.data(), row) == 0);
  CHECK(std::memcmp(&before[row], &after[row], row) != 0);
  CHECK(std::memcmp(&before[2 * row], &after[2 * row], row) == 0);
  CHECK(values<std::int32_t>(output(batch, "oracle_info"))[1] == 2);
  // A seed is one episode, in any environment.
  const std::uint64_t others[] = {9, 9, 2};
  request.seeds = others;
  request.mask = nullptr;
  REQUIRE(engram_reset(batch.get(), &request) == ENGRAM_OK);
  CHECK(std::memcmp(&after[row], &bytes_of(output(batch, "observation"))[2 * row], row) == 0);
}

TEST_CASE("Two halves of a step do what a whole one does", "[c_api][async]") {
  const BatchHandle whole = make_running(same_step(6));
  const BatchHandle halves = make_running(same_step(6));
  for (int i = 0; i < 40; ++i) {
    std::vector<float> actions = actions_of(whole, ENGRAM_POLICY_ORACLE);
    REQUIRE(engram_step(whole.get(), actions.data(), actions.size()) == ENGRAM_OK);
    if (i % 5 == 4) {
      REQUIRE(engram_step(halves.get(), actions.data(), actions.size()) == ENGRAM_OK);
    } else {
      REQUIRE(engram_step_async(halves.get(), actions.data(), actions.size()) == ENGRAM_OK);
      std::fill(actions.begin(), actions.end(), 1e9F);  // they were copied
      REQUIRE(engram_step_wait(halves.get()) == ENGRAM_OK);
    }
    REQUIRE(outputs_of(whole) == outputs_of(halves));
  }
}

TEST_CASE("Between the halves of a step everything else is refused", "[c_api][async]") {
  const BatchHandle batch = make_running(2);
  engram_env* env = batch.get();
  std::vector<float> actions(14);
  std::vector<std::uint8_t> bytes(12);
  engram_array array{};
  std::size_t size = 0;
  REQUIRE(engram_step_async(env, actions.data(), 14) == ENGRAM_OK);
  const auto refused = [](engram_status status) {
    check_refused(status, ENGRAM_BAD_STATE, "a step is under way");
  };
  refused(engram_reset(env, nullptr));
  refused(engram_step(env, actions.data(), 14));
  refused(engram_step_async(env, actions.data(), 14));
  refused(engram_act(env, ENGRAM_POLICY_ZERO, actions.data(), 14));
  refused(engram_output(env, "reward", &array));
  refused(engram_final_output(env, "reward", &array));
  refused(engram_output_at(env, 0, &array));
  refused(engram_instruction(env, 0, nullptr, 0, &size));
  refused(engram_render(env, 0, "base_camera", 2, 2, bytes.data(), 12));
  refused(engram_save(env, 0, nullptr, 0, &size));
  refused(engram_restore(env, 0, bytes.data(), 12));
  CHECK(engram_describe_json(env) == nullptr);
  CHECK(engram_num_envs(env) == 2);  // what never changes can be asked for
  CHECK(engram_num_outputs(env) > 10);
  CHECK(engram_step_wait(env) == ENGRAM_OK);
  check_refused(engram_step_wait(env), ENGRAM_BAD_STATE, "no step is under way");
  CHECK(values<std::int32_t>(output(batch, "elapsed_steps"))[1] == 1);
}

TEST_CASE("A step can be waited for in parts", "[c_api][async]") {
  const BatchHandle batch = make_running(16);
  const std::vector<float> actions = actions_of(batch, ENGRAM_POLICY_RANDOM);
  std::int32_t done = 1;
  check_refused(engram_step_wait_for(batch.get(), 0, &done), ENGRAM_BAD_STATE,
                "no step is under way");
  CHECK(done == 0);
  REQUIRE(engram_step_async(batch.get(), actions.data(), actions.size()) == ENGRAM_OK);
  check_refused(engram_step_wait_for(batch.get(), -1, &done), ENGRAM_INVALID_ARGUMENT, "seconds");
  while (done == 0) {
    check_refused(engram_reset(batch.get(), nullptr), ENGRAM_BAD_STATE, "a step is under way");
    REQUIRE(engram_step_wait_for(batch.get(), 1e-4, &done) == ENGRAM_OK);
  }
  CHECK(values<std::int32_t>(output(batch, "elapsed_steps"))[15] == 1);
  check_refused(engram_step_wait(batch.get()), ENGRAM_BAD_STATE, "no step is under way");
}

TEST_CASE("A refused first half leaves no step under way", "[c_api][async]") {
  const BatchHandle batch = make_running(1);
  float actions[7] = {0, 0, 0, 0, 0, 0, NAN};
  check_refused(engram_step_async(batch.get(), actions, 7), ENGRAM_INVALID_ARGUMENT, "component 6");
  check_refused(engram_step_async(batch.get(), actions, 6), ENGRAM_INVALID_ARGUMENT, "7 needed");
  check_refused(engram_step_wait(batch.get()), ENGRAM_BAD_STATE, "no step is under way");
  CHECK(values<std::int32_t>(output(batch, "elapsed_steps"))[0] == 0);
}

TEST_CASE("Closing waits for a step, and another thread may wait too", "[c_api][async]") {
  for (int i = 0; i < 5; ++i) {
    BatchHandle batch = make_running(16);
    const std::vector<float> actions = actions_of(batch, ENGRAM_POLICY_RANDOM);
    REQUIRE(engram_step_async(batch.get(), actions.data(), actions.size()) == ENGRAM_OK);
    engram_status waited = ENGRAM_INTERNAL;
    std::thread([&] { waited = engram_step_wait(batch.get()); }).join();
    CHECK(waited == ENGRAM_OK);
    REQUIRE(engram_step_async(batch.get(), actions.data(), actions.size()) == ENGRAM_OK);
    batch.reset();
  }
}

TEST_CASE("A batch at work in one thread refuses another", "[c_api]") {
  const BatchHandle batch = make_running(32);
  const std::vector<float> actions(test::action_count(batch));
  std::atomic<bool> refused = false;
  std::atomic<bool> wrong = false;
  std::thread worker([&] {
    while (!refused && !wrong) {
      const engram_status status = engram_step(batch.get(), actions.data(), actions.size());
      if (status != ENGRAM_OK && status != ENGRAM_BAD_STATE) wrong = true;
    }
  });
  while (!refused && !wrong) {
    engram_array array{};
    const engram_status status = engram_output(batch.get(), "reward", &array);
    if (status == ENGRAM_BAD_STATE) {
      wrong = std::string(engram_last_error()).find("another thread") == std::string::npos;
      refused = true;
    } else if (status != ENGRAM_OK) {
      wrong = true;
    }
  }
  worker.join();
  CHECK(refused);
  CHECK_FALSE(wrong);
}

TEST_CASE("Snapshots travel between slots and batches", "[c_api]") {
  const BatchHandle from = make_running(2);
  const BatchHandle to = make_running(default_options(5));
  for (int i = 0; i < 8; ++i) step_by(from, ENGRAM_POLICY_ORACLE);
  std::size_t size = 0;
  REQUIRE(engram_save(from.get(), 1, nullptr, 0, &size) == ENGRAM_OK);
  std::vector<std::byte> bytes(size);
  check_refused(engram_save(from.get(), 1, bytes.data(), size - 1, &size), ENGRAM_INVALID_ARGUMENT,
                "needed");
  CHECK(size == bytes.size());
  REQUIRE(engram_save(from.get(), 1, bytes.data(), size, &size) == ENGRAM_OK);
  REQUIRE(engram_restore(to.get(), 4, bytes.data(), size) == ENGRAM_OK);
  const std::size_t row = 4 * static_cast<std::size_t>(engram_state_dim(from.get()));
  CHECK(std::memcmp(&bytes_of(output(from, "observation"))[row],
                    &bytes_of(output(to, "observation"))[4 * row], row) == 0);

  const auto bad = ENGRAM_INVALID_ARGUMENT;
  check_refused(engram_restore(to.get(), 5, bytes.data(), size), bad, "0 to 4 allowed");
  check_refused(engram_restore(to.get(), -2, bytes.data(), size), bad, "0 to 4 allowed");
  check_refused(engram_save(to.get(), -2, nullptr, 0, &size), bad, "0 to 4 allowed");
  check_refused(engram_restore(to.get(), ENGRAM_WHOLE_BATCH, bytes.data(), size), bad, "5 needed");
  check_refused(engram_restore(to.get(), 0, bytes.data(), 3), bad, "3 bytes given");
  bytes.back() ^= std::byte{1};
  check_refused(engram_restore(to.get(), 0, bytes.data(), size), bad, "damaged");
}

TEST_CASE("Instructions are cut to the capacity given", "[c_api]") {
  const BatchHandle batch = make_running(1);
  std::size_t length = 0;
  REQUIRE(engram_instruction(batch.get(), 0, nullptr, 0, &length) == ENGRAM_OK);
  CHECK(length > 20);
  char text[5] = "####";
  REQUIRE(engram_instruction(batch.get(), 0, text, 5, &length) == ENGRAM_OK);
  CHECK(text == std::string("Obse"));
}

TEST_CASE("Words of an episode are JSON", "[c_api][labels]") {
  const BatchHandle waiting = test::make_batch(test::default_options());
  check_refused(engram_words(waiting.get(), 0, nullptr, 0, nullptr), ENGRAM_BAD_STATE, "reset");
  engram_env* const env = make_running(2).release();
  const BatchHandle batch(env);
  std::size_t length = 0;
  REQUIRE(engram_words(env, 1, nullptr, 0, &length) == ENGRAM_OK);
  std::string text(length, ' ');
  REQUIRE(engram_words(env, 1, text.data(), length + 1, nullptr) == ENGRAM_OK);
  const auto words = nlohmann::json::parse(text);
  CHECK(words["plan"].size() == 4);
  CHECK(words["subtask"] == 0);
  CHECK(words["subtasks_done"] == 0);
  CHECK_THAT(words["memory"].get<std::string>(), Catch::Contains("the cue was a"));
  CHECK_THAT(words["object"].get<std::string>(), Catch::Contains("cube_"));
  CHECK(words["paraphrases"].size() >= 10);
  check_refused(engram_words(env, 2, nullptr, 0, &length), ENGRAM_INVALID_ARGUMENT, "0 to 1");
}

TEST_CASE("Descriptions are JSON and stay where they are", "[c_api]") {
  const auto list = nlohmann::json::parse(engram_list_json());
  REQUIRE(list.size() == engram_num_tasks());
  CHECK(list[0]["id"] == engram_task_id(0));
  CHECK(engram_list_json() == engram_list_json());
  const BatchHandle batch = make_batch(1);
  const char* text = engram_describe_json(batch.get());
  REQUIRE(text != nullptr);
  CHECK(engram_describe_json(batch.get()) == text);
  const auto description = nlohmann::json::parse(text);
  CHECK(description["id"] == kId);
  CHECK(description["state_dim"] == engram_state_dim(batch.get()));
}

TEST_CASE("Steps do not allocate, in one piece or two", "[c_api]") {
  const BatchHandle batch = make_running(same_step(4));
  std::vector<float> actions(28);
  const auto run = [&] {
    return engram_act(batch.get(), ENGRAM_POLICY_RANDOM, actions.data(), 28) == ENGRAM_OK &&
           engram_step(batch.get(), actions.data(), 28) == ENGRAM_OK &&
           engram_step_async(batch.get(), actions.data(), 28) == ENGRAM_OK &&
           engram_step_wait(batch.get()) == ENGRAM_OK;
  };
  REQUIRE(run());  // starts the thread
  int steps = 0;
  const std::int64_t before = test::allocation_count();
  while (steps < 30 && run()) ++steps;
  const std::int64_t after = test::allocation_count();
  CHECK(steps == 30);
  CHECK(after == before);
}

TEST_CASE("A task is described without a handle as with one", "[c_api][describe]") {
  engram_options options = default_options(5);
  options.obs_mode = ENGRAM_OBS_OBJECTS;
  options.constants = R"({"COLORS": 2})";
  const BatchHandle batch = test::make_batch(options);
  char* text = nullptr;
  REQUIRE(engram_describe_task_json(kId, &options, &text) == ENGRAM_OK);
  CHECK(std::string(text) == engram_describe_json(batch.get()));
  engram_free_text(text);
  REQUIRE(engram_describe_task_json(kId, nullptr, &text) == ENGRAM_OK);
  CHECK(nlohmann::json::parse(text)["id"] == kId);
  engram_free_text(text);
  CHECK(engram_describe_task_json("RememberColour3", nullptr, &text) == ENGRAM_UNKNOWN_ID);
  CHECK(text == nullptr);
  options.num_envs = 0;
  CHECK(engram_describe_task_json(kId, &options, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_describe_task_json(kId, nullptr, nullptr) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_describe_task_json(nullptr, nullptr, &text) == ENGRAM_INVALID_ARGUMENT);
}

}  // namespace
}  // namespace engram
