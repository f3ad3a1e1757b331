// Users' own tasks through the C API.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "engram/engram_task.h"
#include "tests/api/c_api_fixture.h"

namespace engram {
namespace {

using Catch::Contains;

constexpr const char* kDefinition =
    R"({"id": "CTask-v0", "family": "CTask", "horizon": 10, "instruction": "Wait.",
        "constants": [{"name": "GOAL", "kind": "integer", "value": 4, "low": 1, "high": 9}]})";
constexpr const char* kDescription =
    R"({"memory": [{"name": "count", "dtype": "int32"}], "methods": ["oracle"]})";

// A task that succeeds after GOAL steps; what a test wants it to do wrong.
struct CTask {
  std::string description = kDescription;
  int failing_method = -1;
  int made = 0;
  int destroyed = 0;
  std::string constants;
  std::map<std::string, engram_task_array> arrays;
  std::vector<engram_task_memory*> kept;
};

int create(void* user, const char* /*id*/, const char* constants, void** instance,
           engram_task_reply* reply) {
  auto* task = static_cast<CTask*>(user);
  ++task->made;
  task->constants = constants;
  *instance = user;
  engram_task_describe(reply, task->description.c_str());
  return 0;
}

int bind(void* instance, const engram_task_array* arrays, size_t count, int32_t /*num_envs*/,
         engram_task_reply* /*reply*/) {
  auto* task = static_cast<CTask*>(instance);
  for (size_t i = 0; i < count; ++i) task->arrays[arrays[i].name] = arrays[i];
  return 0;
}

int call(void* instance, int32_t method, int32_t rows, int32_t of_all, engram_task_reply* reply) {
  auto* task = static_cast<CTask*>(instance);
  if (method == task->failing_method) {
    engram_task_fail(reply, "the lamp is broken");
    return 1;
  }
  const auto at = [&](const char* name) {
    const engram_task_array& array = task->arrays.at(name);
    return of_all != 0 ? array.all : array.subset_rows;
  };
  auto* count = static_cast<int32_t*>(at("memory:count"));
  for (int i = 0; i < rows; ++i) {
    if (method == ENGRAM_TASK_ADVANCE) ++count[i];
    if (method == ENGRAM_TASK_EVALUATE) static_cast<uint8_t*>(at("success"))[i] = count[i] > 4;
    if (method == ENGRAM_TASK_REWARD) static_cast<float*>(at("reward"))[i] = 0.5F;
  }
  return 0;
}

void destroy(void* instance) { ++static_cast<CTask*>(instance)->destroyed; }

engram_task_callbacks callbacks() {
  return {sizeof(engram_task_callbacks), &create, &bind, &call, &destroy};
}

// Tasks stay registered for the life of the process, and so does this one.
CTask& registered() {
  static CTask task;
  task = CTask{};
  const engram_task_callbacks functions = callbacks();
  const engram_status status = engram_register_task(kDefinition, &functions, &task);
  INFO(engram_last_error());
  REQUIRE(status == ENGRAM_OK);
  return task;
}

TEST_CASE("A task of callbacks runs as a built-in one", "[c_api][own_tasks]") {
  CTask& task = registered();
  CHECK(task.made == 1);
  CHECK(task.destroyed == 1);
  {
    engram_options options = test::default_options(3);
    options.constants = R"({"GOAL": 7})";
    const test::BatchHandle batch = test::make_batch(options, "CTask-v0");
    CHECK_THAT(task.constants, Contains(R"("GOAL":7)"));
    REQUIRE(engram_reset(batch.get(), nullptr) == ENGRAM_OK);
    std::vector<float> actions(21);
    engram_array success{};
    for (int step = 1; step <= 5; ++step) {
      REQUIRE(engram_act(batch.get(), ENGRAM_POLICY_ORACLE, actions.data(), 21) == ENGRAM_OK);
      REQUIRE(engram_step(batch.get(), actions.data(), 21) == ENGRAM_OK);
      REQUIRE(engram_output(batch.get(), "success", &success) == ENGRAM_OK);
      CHECK((static_cast<const uint8_t*>(success.data)[1] != 0) == (step >= 4));
    }
    engram_task_memory* memory = task.arrays.at("memory:count").memory;
    engram_task_memory_retain(memory);
    task.kept.push_back(memory);
  }
  // Kept memory outlives the batch.
  CHECK(task.destroyed == 2);
  CHECK(static_cast<const int32_t*>(task.arrays.at("memory:count").all)[2] == 6);
  engram_task_memory_release(task.kept.front());
}

TEST_CASE("A failing callback ends the step and says why", "[c_api][own_tasks]") {
  CTask& task = registered();
  const test::BatchHandle batch = test::make_batch(test::default_options(2), "CTask-v0");
  REQUIRE(engram_reset(batch.get(), nullptr) == ENGRAM_OK);
  const std::vector<float> actions(14);
  task.failing_method = ENGRAM_TASK_EVALUATE;
  CHECK(engram_step(batch.get(), actions.data(), 14) == ENGRAM_TASK_FAILED);
  CHECK(engram_last_error() == std::string("task 'CTask-v0': the lamp is broken"));
  task.failing_method = -1;
  CHECK(engram_step(batch.get(), actions.data(), 14) == ENGRAM_BAD_STATE);
  CHECK_THAT(engram_last_error(), Contains("reset all environments first"));
  CHECK(engram_reset(batch.get(), nullptr) == ENGRAM_OK);
  CHECK(engram_step(batch.get(), actions.data(), 14) == ENGRAM_OK);
}

TEST_CASE("What cannot be registered is refused", "[c_api][own_tasks]") {
  CTask task;
  engram_task_callbacks functions = callbacks();
  const auto refused = [&](const char* definition, const char* why) {
    CHECK(engram_register_task(definition, &functions, &task) == ENGRAM_INVALID_ARGUMENT);
    CHECK_THAT(engram_last_error(), Contains(why));
  };
  refused(nullptr, "a JSON object needed");
  refused("{}", "'id' is missing");
  refused(R"({"id": "no version", "family": "A", "horizon": 9, "instruction": ""})", "-v");
  refused(R"({"id": "RememberColor3-VLA-v0", "family": "A", "horizon": 9, "instruction": ""})",
          "is taken, by a task of the benchmark");
  task.description = R"({"hidden": "lamp"})";
  refused(R"({"id": "CTask-v1", "family": "A", "horizon": 9, "instruction": ""})",
          "hidden variable 'lamp' given, the name of a draw needed");
  functions.call = nullptr;
  refused(kDefinition, "create, bind, call and destroy needed");
  functions.struct_size = 8;
  refused(kDefinition, "struct_size");
}

TEST_CASE("The functions of scripts work on rows", "[c_api][own_tasks]") {
  const double tcp_pos[] = {0, 0, 0.2, 0, 0, 0.2};
  const double tcp_quat[] = {0, 1, 0, 0, 0, 1, 0, 0};
  const double goals[] = {0.01, 0, 0.2, 0, 0, 0.1};
  const double grippers[] = {1, -1};
  float actions[14] = {};
  REQUIRE(engram_servo_tcp(2, tcp_pos, tcp_quat, goals, tcp_quat, grippers, actions) == ENGRAM_OK);
  CHECK(actions[0] == Approx(0.16));
  CHECK(actions[2] == 0);
  CHECK(actions[7 + 2] == -1);
  CHECK((actions[6] == 1 && actions[13] == -1));

  double waypoints[6] = {};
  const double far[] = {0.1, 0, 0.05, 0, 0, 0.05};
  REQUIRE(engram_approach_from_above(2, tcp_pos, far, 0.06, waypoints) == ENGRAM_OK);
  CHECK(waypoints[2] == Approx(0.11));
  CHECK(waypoints[5] == Approx(0.05));

  // Forces on the fingers of the second of two props, against their opening directions.
  double forces[24] = {};
  forces[6 + 1] = -2;
  forces[6 + 3 + 1] = 2;
  uint8_t held[2] = {};
  REQUIRE(engram_is_grasping(2, tcp_quat, forces, 2, 1, 0.5, 85, held) == ENGRAM_OK);
  CHECK((held[0] == 1 && held[1] == 0));
  CHECK(engram_is_grasping(2, tcp_quat, forces, 2, 2, 0.5, 85, held) == ENGRAM_INVALID_ARGUMENT);

  const uint64_t keys[] = {5, 5};
  const uint64_t episodes[] = {0, 1};
  double numbers[4] = {};
  double again[4] = {};
  REQUIRE(engram_guesses(2, keys, episodes, 2, numbers) == ENGRAM_OK);
  REQUIRE(engram_guesses(2, keys, episodes, 2, again) == ENGRAM_OK);
  CHECK(std::memcmp(numbers, again, sizeof numbers) == 0);
  CHECK(numbers[0] != numbers[2]);

  const double x[] = {0.5, 1};
  const double y[] = {2, 3};
  double values[2] = {};
  REQUIRE(engram_real_function("tanh", 2, x, nullptr, values) == ENGRAM_OK);
  CHECK(values[1] == Approx(std::tanh(1)));
  REQUIRE(engram_real_function("atan2", 2, x, y, values) == ENGRAM_OK);
  CHECK(values[0] == Approx(std::atan2(0.5, 2)));
  CHECK(engram_real_function("tanh", 2, x, y, values) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_real_function("gamma", 2, x, nullptr, values) == ENGRAM_INVALID_ARGUMENT);
  CHECK_THAT(engram_last_error(), Contains("function 'gamma' given"));
}

TEST_CASE("A tour visits its stops", "[c_api][own_tasks]") {
  const double tcp_pos[] = {0, -0.1, 0.05};
  const double qvel[9] = {};
  const int32_t elapsed[] = {10};
  const double stops[] = {0, 0.1, 0.05, 0, -0.1, 0.05};
  double goals[3] = {};
  uint8_t rests[1] = {};
  REQUIRE(engram_tour(1, tcp_pos, qvel, elapsed, stops, 2, 0.13, 0.025, 0, 1, goals, rests) ==
          ENGRAM_OK);
  CHECK(goals[1] == Approx(0.1));  // it has rested at the first one
  CHECK(engram_tour(1, tcp_pos, qvel, elapsed, stops, 0, 0.13, 0.025, 0, 1, goals, rests) ==
        ENGRAM_INVALID_ARGUMENT);
}

}  // namespace
}  // namespace engram
