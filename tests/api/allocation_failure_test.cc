// Memory that runs out, at any allocation of a call: the call says so, changes nothing, leaks
// nothing, and the batch goes on.
#include <filesystem>
#include <functional>
#include <memory>

#include "protocol/make/task_description.h"
#include "tasks/family_samples.h"
#include "tasks/registry.h"
#include "tests/allocation_counter.h"
#include "tests/api/c_api_fixture.h"
#include "tests/failing_allocations.h"
#include "tests/sanitizers.h"
#include "tests/temporary_folder.h"

namespace engram {
namespace {

using test::BatchHandle, test::FailingAllocation, test::fails_well_everywhere, test::make_running;

// Every allocation at first, then ever fewer of them.
std::int64_t next(std::int64_t number) { return number < 40 ? number + 1 : number + number / 8; }

engram_options small_options() {
  engram_options options = test::default_options(2);
  options.threads = 1;
  return options;
}

std::vector<std::uint8_t> saved(const BatchHandle& batch) {
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
    const BatchHandle batch = make_running(small_options());
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
    // The call and the batch work afterwards.
    CHECK(call.run(batch.get()) == ENGRAM_OK);
    const std::vector<float> actions = test::actions_of(batch, ENGRAM_POLICY_ORACLE);
    CHECK(engram_step(batch.get(), actions.data(), actions.size()) == ENGRAM_OK);
  }
  const std::int64_t leaked = test::outstanding_allocations() - before;  // INFO allocates
  INFO(call.name << ", allocation " << number);
  CHECK(leaked == 0);
  return happened;
}

TEST_CASE("C API: a call that runs out of memory changes nothing", "[api][allocation]") {
  const BatchHandle keeper = make_running(small_options());  // the scenes stay compiled
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
      {"step_no_action", [](engram_env* env) { return engram_step_no_action(env); }},
      {"step_async",
       [&](engram_env* env) {
         const engram_status status = engram_step_async(env, actions.data(), actions.size());
         return status == ENGRAM_OK ? engram_step_wait(env) : status;
       }},
      {"instruction",
       [](engram_env* env) { return engram_instruction(env, 0, nullptr, 0, nullptr); }},
      {"words", [](engram_env* env) { return engram_words(env, 0, nullptr, 0, nullptr); }},
      {"question", [](engram_env* env) { return engram_question(env, 0, nullptr, 0, nullptr); }},
      {"save",
       [](engram_env* env) {
         std::size_t size = 0;
         return engram_save(env, 0, nullptr, 0, &size);
       }},
      {"describe",
       [](engram_env* env) {
         return engram_describe_json(env) != nullptr ? ENGRAM_OK : ENGRAM_UNAVAILABLE;
       }},
      {"restore",
       [&](engram_env* env) {
         return engram_restore(env, ENGRAM_WHOLE_BATCH, state.data(), state.size());
       }},
  };
  for (const Call& call : calls) {
    {
      INFO(call.name << ", with what is made once for the whole process");  // so is INFO's buffer
      const BatchHandle warm = make_running(small_options());
      CHECK(call.run(warm.get()) == ENGRAM_OK);
    }
    std::int64_t number = 1;
    while (fails_well(call, number)) number = next(number);
  }
}

// A batch that was asked for with a failing allocation.
struct Attempt {
  bool happened = false;  // the call came as far as that allocation
  bool reported = false;  // either a batch, or none and a status that says why
  bool in_mujoco = false;
  std::int64_t leaked = 0;
};

Attempt try_to_make(const engram_options& options, std::int64_t number) {
  const std::int64_t before = test::outstanding_allocations();
  Attempt attempt;
  {
    engram_env* env = nullptr;
    engram_status status = ENGRAM_OK;
    {
      const FailingAllocation failing(number);
      status = engram_make(test::kId, &options, &env);
      attempt.happened = FailingAllocation::happened();
    }
    const BatchHandle batch(env);
    const char* error = status == ENGRAM_OK ? "" : engram_last_error();
    // MuJoCo's parser may take the failure for one of the scene's text.
    const bool misread = std::strstr(error, "refused by MuJoCo") != nullptr;
    attempt.in_mujoco = misread || std::strstr(error, "MuJoCo: ") != nullptr;
    attempt.reported = status == ENGRAM_OK
                           ? env != nullptr
                           : env == nullptr && (status == ENGRAM_UNAVAILABLE || misread);
  }
  attempt.leaked = test::outstanding_allocations() - before;  // INFO allocates
  return attempt;
}

// Attempts, given as attempt(number), with each allocation failing in turn, or one of `stride`
// after the first hundred; all must report it and none may leak. Returns how many allocations there
// are.
template <class F>
std::int64_t all_fail_well(F&& attempt_with, int stride = 1) {
  std::int64_t number = 1;
  int lost = 0;
  for (Attempt attempt{.happened = true}; attempt.happened; number += number < 100 ? 1 : stride) {
    attempt = attempt_with(number);
    INFO("allocation " << number << ": " << engram_last_error());
    CHECK(attempt.reported);
    // mj_makeData loses up to two blocks that it has already.
    if (attempt.in_mujoco) CHECK(attempt.leaked <= 2);
    if (!attempt.in_mujoco && attempt.leaked != 0) ++lost;
  }
  // A pool of tinyxml2 loses a block if its list of blocks cannot grow.
  CHECK(lost <= 1);
  return number;
}

TEST_CASE("A batch that there is no memory for is not made", "[api][allocation]") {
  const test::ForgivenLeaks forgiven;                        // counted below
  const BatchHandle keeper = make_running(small_options());  // the scenes stay compiled
  const test::MujocoMemory counted;
  const engram_options options = test::default_options(4);
  const auto attempt = [&](std::int64_t number) { return try_to_make(options, number); };
  attempt(1'000'000'000);  // what is made once for the whole process
  CHECK(all_fail_well(attempt) > 1000);
}

// Compiling a scene is MuJoCo's work: what it leaks when memory runs out there is its own.
TEST_CASE("Scenes that there is no memory for end no program", "[api][allocation]") {
  const test::ForgivenLeaks forgiven;
  const test::MujocoMemory counted;
  engram_options options = small_options();
  options.num_envs = 1;
  options.obs_mode = ENGRAM_OBS_RGB;  // images compile the scene once more
  options.image_width = options.image_height = 8;
  std::int64_t number = 1;
  for (Attempt attempt{.happened = true}; attempt.happened; number += 1 + number / 2) {
    attempt = try_to_make(options, number);
    INFO("allocation " << number << ": " << engram_last_error());
    CHECK(attempt.reported);
  }
  CHECK(number > 1000);
}

TEST_CASE("Tasks that there is no memory for are not made", "[api][allocation]") {
  for (const std::string& id : one_of_each_family()) {
    INFO(id);
    CHECK(fails_well_everywhere([&id] {
            const std::unique_ptr<Task> task = make_task(id);
            (void)task->scene();
          }) > 20);
    const RegistryEntry& entry = require_entry(id);
    CHECK(fails_well_everywhere([&entry] { (void)to_text(describe_entry(entry)); }) > 60);
  }
}

void check_descriptions(std::int64_t all) {
  const std::unique_ptr<Batch> batch = make(test::kId);
  CHECK(fails_well_everywhere([&batch] { (void)to_text(describe_task(*batch)); }, all) > 500);
}

TEST_CASE("Descriptions that there is little memory for are not made", "[api][allocation]") {
  check_descriptions(200);
}

TEST_CASE("Descriptions that there is no memory for are not made", "[api][allocation][long]") {
  check_descriptions(test::kEveryAllocation);
}

// --- evaluations ---

struct FreeText {
  void operator()(char* text) const { engram_free_text(text); }
};
using Text = std::unique_ptr<char, FreeText>;

// An evaluation of one episode that goes on in the folder, if there is one.
struct Evaluation {
  std::string resume = {};

  // The document, or none and the status that says why.
  Text run(engram_status& status) const {
    const auto still = [](void*, const engram_policy_request* request,
                          engram_policy_reply* reply) -> int {
      constexpr float kZeros[7] = {};
      constexpr std::int64_t kShape[] = {7};
      for (std::int32_t row = 0; row < request->count; ++row) {
        if (engram_policy_set(reply, row, kZeros, kShape, 1) != ENGRAM_OK) return 1;
      }
      return 0;
    };
    engram_evaluation_options options = test::evaluation_options(1);
    options.num_envs = options.threads = 1;
    options.config_json = R"({"weights": ["a", 1.5, null], "of": {"more": true}})";
    options.resume = resume.empty() ? nullptr : resume.c_str();
    char* text = nullptr;
    status = engram_evaluate(&options, still, nullptr, &text);
    return Text(text);
  }
};

// What becomes of it with a failing allocation.
Attempt try_to_evaluate(const Evaluation& evaluation, std::int64_t number,
                        const std::string& expected) {
  const std::int64_t before = test::outstanding_allocations();
  Attempt attempt;
  {
    engram_status status = ENGRAM_OK;
    Text document;
    {
      const FailingAllocation failing(number);
      document = evaluation.run(status);
      attempt.happened = FailingAllocation::happened();
    }
    const char* error = status == ENGRAM_OK ? "" : engram_last_error();
    attempt.in_mujoco = std::strstr(error, "MuJoCo") != nullptr;
    attempt.reported = status == ENGRAM_OK ? document != nullptr && document.get() == expected
                                           : document == nullptr && *error != '\0';
    if (!attempt.happened) attempt.reported = attempt.reported && status == ENGRAM_OK;
  }
  attempt.leaked = test::outstanding_allocations() - before;  // INFO allocates
  return attempt;
}

std::int64_t all_fail_well(const Evaluation& evaluation, const std::string& expected,
                           int stride = 1) {
  return all_fail_well(
      [&](std::int64_t number) { return try_to_evaluate(evaluation, number, expected); }, stride);
}

void check_begun(int stride) {
  const test::ForgivenLeaks forgiven;                        // counted below
  const BatchHandle keeper = make_running(small_options());  // the scenes stay compiled
  engram_status status = ENGRAM_OK;
  const std::string expected = Evaluation{}.run(status).get();
  const test::MujocoMemory counted;
  CHECK(all_fail_well(Evaluation{}, expected, stride) > 1000);
}

TEST_CASE("C API: evaluations that there is no memory for", "[api][allocation]") { check_begun(5); }

TEST_CASE("C API: evaluations that there is no memory for, at any allocation",
          "[api][allocation][long]") {
  check_begun(1);
}

// Results are there, and are read, summed up and written again.
void check_finished(int stride) {
  const test::TemporaryFolder folder;
  const Evaluation evaluation{folder.path().string()};
  engram_status status = ENGRAM_OK;
  const std::string expected = evaluation.run(status).get();
  CHECK(all_fail_well(evaluation, expected, stride) > 300);
}

TEST_CASE("C API: finished evaluations that there is no memory for", "[api][allocation]") {
  check_finished(25);
}

TEST_CASE("C API: finished evaluations that there is no memory for, at any allocation",
          "[api][allocation][long]") {
  check_finished(1);
}

// Images of what was seen go into the folder, and need a scene (see above).
TEST_CASE("C API: evaluations into a folder that there is no memory for end no program",
          "[api][allocation]") {
  const test::ForgivenLeaks forgiven;
  const BatchHandle keeper = make_running(small_options());
  engram_status status = ENGRAM_OK;
  const std::string expected = Evaluation{}.run(status).get();
  const test::MujocoMemory counted;
  std::int64_t number = 1;
  for (Attempt attempt{.happened = true}; attempt.happened; number = next(number)) {
    const test::TemporaryFolder folder;
    attempt = try_to_evaluate({folder.path().string()}, number, expected);
    INFO("allocation " << number << ": " << engram_last_error());
    CHECK(attempt.reported);
  }
  CHECK(number > 1000);
}

// The list is made once in a process.
TEST_CASE("C API: the list of tasks is whole or not there", "[api][allocation]") {
  std::int64_t number = 1;
  bool listed = false;
  while (!listed) {
    const std::int64_t before = test::outstanding_allocations();
    {
      const FailingAllocation failing(number);
      listed = engram_list_json() != nullptr;
    }
    const std::int64_t left = test::outstanding_allocations() - before;  // INFO allocates
    INFO("allocation " << number);
    if (!listed) {
      CHECK_THAT(engram_last_error(), Catch::Matchers::Equals("out of memory"));
      CHECK(left == 0);
    }
    number = next(number);
  }
  CHECK(parse_json(engram_list_json()));
}

}  // namespace
}  // namespace engram
