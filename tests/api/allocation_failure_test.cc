// Memory that runs out, at any allocation of a call: the call says so, changes nothing, leaks
// nothing, and the batch goes on.
#include <functional>

#include "core/error.h"
#include "core/vector_env.h"
#include "render/document_source.h"
#include "tasks/registry.h"
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
  const std::int64_t leaked = test::outstanding_allocations() - before;  // INFO allocates
  INFO(call.name << ", allocation " << number);
  CHECK(leaked == 0);
  return happened;
}

// Documents are left out: destructors of the JSON library allocate, and end the program if they
// cannot (docs/testing.md).
TEST_CASE("C door: a call that runs out of memory changes nothing", "[api][allocation]") {
  const Batch keeper = make_running(small_options());  // the scenes stay compiled
  const test::MujocoMemory counted;
  const std::vector<std::uint8_t> state = saved(keeper);
  const std::vector<float> actions(14);
  const double target = 1;
  const engram_pin pin = {"target", &target, 1};
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
      {"step", [&](engram_env* env) { return engram_step(env, actions.data(), actions.size()); }},
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

// Makes a batch of a task that there is already, with the allocation of that number failing.
// Returns whether it happened. (The description of a task itself is made before: destructors of
// half-built initialiser lists are more than GCC 12 gets right.)
bool make_fails_well(const EnvOptions& options, std::int64_t number, bool may_leak) {
  const std::int64_t before = test::outstanding_allocations();
  bool happened = false;
  std::string failure;
  {
    std::unique_ptr<Task> task = make_task(test::kId);
    const FailingAllocation failing(number);
    try {
      VectorEnv env(std::move(task), options, make_document_source);
    } catch (const std::bad_alloc&) {
      happened = true;
    } catch (const Error& error) {
      // MuJoCo's parser may take the failure for one of the scene's text.
      const bool misread = may_leak && std::strstr(error.what(), "refused by MuJoCo") != nullptr;
      if (error.kind() != Error::kUnavailable && !misread) failure = error.what();
      happened = true;
    }
    happened = happened || FailingAllocation::happened();
  }
  const std::int64_t leaked = test::outstanding_allocations() - before;  // INFO allocates
  INFO("allocation " << number);
  CHECK(failure == "");
  if (!may_leak) CHECK(leaked == 0);
  return happened;
}

TEST_CASE("A batch that there is no memory for is not made", "[api][allocation]") {
  const Batch keeper = make_running(small_options());  // the scenes stay compiled
  const test::MujocoMemory counted;
  EnvOptions options;
  options.num_envs = 4;
  options.threads = 2;
  std::int64_t number = 1;
  make_fails_well(options, 1'000'000'000, true);  // what is made once for the whole process
  while (make_fails_well(options, number, false)) number = next(number);
  CHECK(number > 100);
}

// Compiling a scene is MuJoCo's work: what it leaks when memory runs out there is its own.
TEST_CASE("Scenes that there is no memory for end no program", "[api][allocation]") {
  const test::MujocoMemory counted;
  EnvOptions options;
  options.threads = 1;
  options.obs_mode = ObsMode::kRgb;  // pictures compile the scene once more
  options.images.width = options.images.height = 8;
  std::int64_t number = 1;
  while (make_fails_well(options, number, true)) number += 1 + number / 2;
  CHECK(number > 1000);
}

}  // namespace
}  // namespace engram
