// Memory that runs out, at any allocation of a call: the call says so, changes nothing, leaks
// nothing, and the batch goes on.
#include <functional>

#include "tests/allocation_counter.h"
#include "tests/api/door.h"

namespace engram {
namespace {

using test::Batch;
using test::FailingAllocation;
using test::make_running;

// Every allocation at first, then ever fewer of them.
std::int64_t next(std::int64_t number) { return number < 40 ? number + 1 : number + number / 8; }

engram_options small_options() {
  engram_options options = test::default_options(2);
  options.threads = 1;
  return options;
}

std::vector<std::uint8_t> saved(const Batch& batch) {
  std::size_t size = 0;
  REQUIRE(engram_save(batch.get(), ENGRAM_WHOLE_BATCH, nullptr, 0, &size) == ENGRAM_OK);
  std::vector<std::uint8_t> bytes(size);
  REQUIRE(engram_save(batch.get(), ENGRAM_WHOLE_BATCH, bytes.data(), size, &size) == ENGRAM_OK);
  return bytes;
}

struct Call {
  const char* name;
  std::function<engram_status(engram_env*)> run;
};

// Runs the call on a running batch, with the allocation of that number failing. False once the call
// has no more allocations than that.
bool fails_well(const Call& call, std::int64_t number) {
  const std::int64_t before = test::outstanding_allocations();
  bool happened = false;
  {
    const Batch batch = make_running(small_options());
    const std::vector<std::uint8_t> state = saved(batch);
    engram_status status = ENGRAM_OK;
    {
      const FailingAllocation failing(number);
      status = call.run(batch.get());
      happened = FailingAllocation::happened();
    }
    INFO(call.name << ", allocation " << number << ": " << engram_last_error());
    if (status != ENGRAM_OK) {
      CHECK(status == ENGRAM_UNAVAILABLE);
      CHECK(*engram_last_error() != '\0');
      CHECK((saved(batch) == state));
    }
    CHECK((happened || status == ENGRAM_OK));
    // The same call, and the batch, work afterwards.
    CHECK(call.run(batch.get()) == ENGRAM_OK);
    const std::vector<float> actions = test::actions_of(batch, ENGRAM_POLICY_ORACLE);
    CHECK(engram_step(batch.get(), actions.data(), actions.size()) == ENGRAM_OK);
  }
  CHECK(test::outstanding_allocations() == before);
  return happened;
}

TEST_CASE("C door: a call that runs out of memory changes nothing", "[api][allocation]") {
  const Batch keeper = make_running(small_options());  // the scenes stay compiled
  const test::MujocoMemory counted;
  const std::vector<std::uint8_t> state = saved(keeper);
  const std::vector<float> actions(14);
  const double target = 1;
  const engram_pin pin = {"target", &target, 1};
  std::vector<std::uint8_t> rgb(3 * 8 * 8);
  const Call calls[] = {
      {"reset", [](engram_env* env) { return engram_reset(env, nullptr); }},
      {"reset with pins",
       [&](engram_env* env) {
         engram_reset_request request{};
         request.pins = &pin;
         request.num_pins = 1;
         request.has_pins = 1;
         return engram_reset(env, &request);
       }},
      {"step",
       [&](engram_env* env) { return engram_step(env, actions.data(), actions.size()); }},
      {"step_async",
       [&](engram_env* env) {
         const engram_status status = engram_step_async(env, actions.data(), actions.size());
         return status == ENGRAM_OK ? engram_step_wait(env) : status;
       }},
      {"instruction",
       [](engram_env* env) { return engram_instruction(env, 0, nullptr, 0, nullptr); }},
      {"save",
       [](engram_env* env) {
         std::size_t size = 0;
         return engram_save(env, 0, nullptr, 0, &size);
       }},
      {"restore",
       [&](engram_env* env) {
         return engram_restore(env, ENGRAM_WHOLE_BATCH, state.data(), state.size());
       }},
      {"describe",
       [](engram_env* env) {
         return engram_describe_json(env) != nullptr ? ENGRAM_OK : ENGRAM_UNAVAILABLE;
       }},
      {"render",
       [&](engram_env* env) {
         return engram_render(env, 0, "render_camera", 8, 8, rgb.data(), rgb.size());
       }},
  };
  for (const Call& call : calls) {
    {
      const Batch warm = make_running(small_options());
      CHECK(call.run(warm.get()) == ENGRAM_OK);  // what is made once for the whole process
    }
    std::int64_t number = 1;
    while (fails_well(call, number)) number = next(number);
  }
}

TEST_CASE("C door: a batch that there is no memory for is not made", "[api][allocation]") {
  const Batch keeper = make_running(small_options());
  const test::MujocoMemory counted;
  engram_options options = small_options();
  options.obs_mode = GENERATE(ENGRAM_OBS_STATE, ENGRAM_OBS_RGB);
  options.image_width = options.image_height = 8;
  options.threads = 2;
  make_running(options).reset();
  bool happened = true;
  for (std::int64_t number = 1; happened; number = next(number)) {
    const std::int64_t before = test::outstanding_allocations();
    engram_env* env = nullptr;
    engram_status status = ENGRAM_OK;
    {
      const FailingAllocation failing(number);
      status = engram_make(test::kId, &options, &env);
      happened = FailingAllocation::happened();
    }
    INFO("allocation " << number << ": " << engram_last_error());
    CHECK((status == ENGRAM_UNAVAILABLE || status == ENGRAM_OK));
    CHECK((env != nullptr) == (status == ENGRAM_OK));
    engram_close(env);
    CHECK(test::outstanding_allocations() == before);
  }
}

// Compiling a scene is MuJoCo's work: what it leaks when memory runs out there is its own.
TEST_CASE("C door: scenes that there is no memory for are not made", "[api][allocation]") {
  const test::MujocoMemory counted;
  bool happened = true;
  for (std::int64_t number = 1; happened; number += 1 + number / 2) {
    const engram_options options = small_options();
    engram_env* env = nullptr;
    engram_status status = ENGRAM_OK;
    {
      const FailingAllocation failing(number);
      status = engram_make(test::kId, &options, &env);
      happened = FailingAllocation::happened();
    }
    INFO("allocation " << number << ": " << engram_last_error());
    CHECK((status == ENGRAM_UNAVAILABLE || status == ENGRAM_OK));
    CHECK((env != nullptr) == (status == ENGRAM_OK));
    engram_close(env);
  }
}

}  // namespace
}  // namespace engram
