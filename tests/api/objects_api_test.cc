// The objects observation through the plain C API.
#include <nlohmann/json.hpp>

#include "protocol/make/make.h"
#include "tests/api/c_api_fixture.h"

namespace engram {
namespace {

using test::actions_of, test::BatchHandle, test::bytes_of, test::check_refused,
    test::default_options, test::kId, test::make_batch, test::make_running, test::output,
    test::step_by, test::values;

engram_options seeing(int num_envs, engram_obs_mode mode = ENGRAM_OBS_OBJECTS) {
  engram_options options = default_options(num_envs);
  options.obs_mode = mode;
  options.auto_reset = ENGRAM_AUTO_RESET_SAME_STEP;
  return options;
}

nlohmann::json parts_of(const BatchHandle& batch) {
  return nlohmann::json::parse(engram_describe_json(batch.get()))["state_fields"];
}

TEST_CASE("The C API shows the engine's objects, and the last ones of an episode",
          "[c_api][objects]") {
  const BatchHandle batch = make_running(seeing(3));
  const BatchOptions options{
      .num_envs = 3, .seed = 11, .obs_mode = ObsMode::kObjects, .auto_reset = AutoReset::kSameStep};
  const std::unique_ptr<Batch> engine = make(kId, options);
  engine->reset();
  engram_array last{};
  REQUIRE(engram_final_output(batch.get(), "observation", &last) == ENGRAM_OK);
  int ended = 0;
  for (int i = 0; i < 30; ++i) {
    const engram_array now = output(batch, "observation");
    REQUIRE(now.shape[1] == engram_state_dim(batch.get()));
    REQUIRE(engine->outputs().observation.size_bytes() == test::size_of(now));
    REQUIRE(std::memcmp(now.data, engine->outputs().observation.data(), test::size_of(now)) == 0);
    if (engine->outputs().final_mask[0] != 0) {
      ++ended;
      const std::byte* kept = engine->final_output("observation").row(0);
      CHECK(std::memcmp(last.data, kept, test::size_of(last)) == 0);
      CHECK(bytes_of(last) != bytes_of(now));
    }
    const std::vector<float> actions = actions_of(batch, ENGRAM_POLICY_RANDOM);
    engine->step(actions);
    REQUIRE(engram_step(batch.get(), actions.data(), actions.size()) == ENGRAM_OK);
  }
  CHECK(ended == 1);
}

TEST_CASE("The C API describes every part of a row, and rows lie in the ranges",
          "[c_api][objects]") {
  engram_options options = seeing(4);
  options.observe_time = 1;
  const BatchHandle batch = make_running(options);
  const nlohmann::json parts = parts_of(batch);
  int width = 0;
  for (const nlohmann::json& part : parts) {
    CHECK(part["offset"] == width);
    width += part["width"].get<int>();
    if (part.contains("names")) CHECK(part["names"].size() == part["width"].get<std::size_t>());
  }
  CHECK(width == engram_state_dim(batch.get()));
  CHECK(parts[0]["name"] == "qpos");
  CHECK(parts[2]["name"] == "tcp_pose");
  CHECK(parts[2]["unit"] == "0.5 m");
  CHECK(parts[3]["name"] == "time");
  CHECK(parts[4]["name"] == "object_0_seen");
  CHECK(parts[8]["name"] == "object_0_color");
  CHECK(parts[8]["names"][0] == "red");
  for (int i = 0; i < 30; ++i) {
    const engram_array rows = output(batch, "observation");
    for (int row = 0; row < 4; ++row) {
      const float* value = values<float>(rows) + row * width;
      for (const nlohmann::json& part : parts) {
        for (int k = 0; k < part["width"].get<int>(); ++k, ++value) {
          INFO(part["name"]);
          REQUIRE(static_cast<double>(*value) >= part["low"].get<double>());
          REQUIRE(static_cast<double>(*value) <= part["high"].get<double>());
        }
      }
    }
    step_by(batch, ENGRAM_POLICY_RANDOM);
  }
  // The outputs' description has the width that is there.
  const auto outputs = nlohmann::json::parse(engram_describe_json(batch.get()))["outputs"];
  for (const nlohmann::json& one : outputs) {
    if (one["name"] == "observation") CHECK(one["width"] == width);
  }
}

TEST_CASE("By name it is the same row, and the time is there where it is asked for",
          "[c_api][objects]") {
  const BatchHandle batch = make_running(seeing(2));
  const BatchHandle named = make_running(seeing(2, ENGRAM_OBS_OBJECTS_DICT));
  engram_options timed = seeing(2);
  timed.observe_time = 1;
  const BatchHandle with_time = make_running(timed);
  CHECK(parts_of(named) == parts_of(batch));
  CHECK(engram_state_dim(with_time.get()) == engram_state_dim(batch.get()) + 1);
  const auto at = parts_of(with_time)[3]["offset"].get<int>();
  for (int i = 0; i < 10; ++i) {
    CHECK(bytes_of(output(named, "observation")) == bytes_of(output(batch, "observation")));
    CHECK(values<float>(output(with_time, "observation"))[at] ==
          Approx(static_cast<double>(i) / engram_horizon(batch.get())));
    for (const BatchHandle* one : {&batch, &named, &with_time}) step_by(*one, ENGRAM_POLICY_RANDOM);
  }
  timed.observe_time = 2;
  engram_env* env = nullptr;
  check_refused(engram_make(kId, &timed, &env), ENGRAM_INVALID_ARGUMENT,
                "observe_time: 2 given, 0 or 1");
}

TEST_CASE("Objects are restored with what surrounds them", "[c_api][objects]") {
  const BatchHandle from = make_running(seeing(2));
  const BatchHandle to = make_running(seeing(5));
  for (int i = 0; i < 12; ++i) step_by(from, ENGRAM_POLICY_RANDOM);
  std::size_t size = 0;
  REQUIRE(engram_save(from.get(), 1, nullptr, 0, &size) == ENGRAM_OK);
  std::vector<std::byte> bytes(size);
  REQUIRE(engram_save(from.get(), 1, bytes.data(), size, &size) == ENGRAM_OK);
  const std::vector<std::byte> before = bytes_of(output(from, "observation"));
  REQUIRE(engram_restore(to.get(), 4, bytes.data(), size) == ENGRAM_OK);
  const std::size_t row = before.size() / 2;
  CHECK(std::memcmp(&before[row], &bytes_of(output(to, "observation"))[4 * row], row) == 0);
  for (int i = 0; i < 3; ++i) step_by(from, ENGRAM_POLICY_RANDOM);
  CHECK(bytes_of(output(from, "observation")) != before);
  REQUIRE(engram_restore(from.get(), 1, bytes.data(), size) == ENGRAM_OK);
  CHECK(std::memcmp(&before[row], &bytes_of(output(from, "observation"))[row], row) == 0);
}

}  // namespace
}  // namespace engram
