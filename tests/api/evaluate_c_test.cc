// The C API to the evaluation protocol.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/api/c_api_fixture.h"
#include "tests/temporary_folder.h"

namespace {

using ParsedJson = nlohmann::ordered_json;

struct Call {
  int requests = 0;
  int64_t shape[3] = {1, 4, 7};
  int32_t ndim = 3;
  engram_status status = ENGRAM_OK;
};

// Zeros in chunks of the shape that the caller wants.
int still(void* user, const engram_policy_request* request, engram_policy_reply* reply) {
  auto& call = *static_cast<Call*>(user);
  ++call.requests;
  const std::vector<float> zeros(4 * 7, 0.0F);
  for (int32_t row = 0; row < request->count; ++row) {
    call.status = engram_policy_set(reply, row, zeros.data(), call.shape, call.ndim);
    if (call.status == ENGRAM_OK) continue;
    engram_policy_fail(reply, engram_last_error());
    return 1;
  }
  return 0;
}

ParsedJson evaluated(const engram_evaluation_options& options, engram_policy_callback policy,
                     void* user) {
  char* text = nullptr;
  REQUIRE(engram_evaluate(&options, policy, user, &text) == ENGRAM_OK);
  ParsedJson document = ParsedJson::parse(text);
  engram_free_text(text);
  return document;
}

}  // namespace

TEST_CASE("C API: an empty text is no name and no folder", "[evaluation]") {
  Call call;
  for (const char* engram_evaluation_options::*const field :
       {&engram_evaluation_options::name, &engram_evaluation_options::output,
        &engram_evaluation_options::resume, &engram_evaluation_options::shard}) {
    engram_evaluation_options options = engram::test::evaluation_options(1);
    options.*field = "";
    char* text = nullptr;
    CHECK(engram_evaluate(&options, &still, &call, &text) == ENGRAM_INVALID_ARGUMENT);
    CHECK_THAT(engram_last_error(), Catch::Contains(": '' given, a text needed"));
  }
  CHECK(call.requests == 0);
}

TEST_CASE("C API: an evaluation has a control mode and a proprio", "[evaluation]") {
  const auto dims = [](void* user, const engram_policy_request* request,
                       engram_policy_reply* reply) {
    auto& seen = *static_cast<std::pair<int, int>*>(user);
    seen = {request->proprio_dim, request->action_dim};
    const std::vector<float> zeros(static_cast<std::size_t>(request->action_dim), 0.0F);
    const int64_t shape[] = {request->action_dim};
    for (int32_t row = 0; row < request->count; ++row) {
      engram_policy_set(reply, row, zeros.data(), shape, 1);
    }
    return 0;
  };
  engram_evaluation_options options = engram::test::evaluation_options(1);
  std::pair<int, int> seen;
  evaluated(options, dims, &seen);
  CHECK(seen == std::pair(7, 7));
  options.control_mode = "pd_joint_delta_pos";
  options.joint_proprio = 1;
  CHECK(evaluated(options, dims, &seen)["tasks"][0]["control_mode"] == "pd_joint_delta_pos");
  CHECK(seen == std::pair(8, 8));
  options.control_mode = "pd";
  char* text = nullptr;
  CHECK(engram_evaluate(&options, dims, &seen, &text) == ENGRAM_UNKNOWN_ID);
  options.control_mode = nullptr;
  options.joint_proprio = 2;
  CHECK(engram_evaluate(&options, dims, &seen, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK_THAT(engram_last_error(), Catch::Contains("joint_proprio: 2 given, 0 or 1 allowed"));
}

TEST_CASE("C API: a policy tells what it is", "[evaluation]") {
  struct Policy {
    std::vector<std::string> told;
    engram_status status = ENGRAM_OK;
    Call call;
  };
  const auto act = [](void* user, const engram_policy_request* request,
                      engram_policy_reply* reply) {
    auto& policy = *static_cast<Policy*>(user);
    if (!policy.told.empty()) {
      policy.status = engram_policy_identify(reply, policy.told.front().c_str());
      policy.told.erase(policy.told.begin());
    }
    return still(&policy.call, request, reply);
  };
  const engram::test::TemporaryFolder folder;
  engram_evaluation_options options = engram::test::evaluation_options(1);
  const std::string output = folder.path().string();
  options.output = output.c_str();
  Policy policy;
  policy.told = {R"({"checkpoint": "a"})", R"({"checkpoint": "a", "more": 1})"};
  evaluated(options, act, &policy);
  CHECK(policy.status == ENGRAM_OK);
  const auto run = std::filesystem::directory_iterator(
                       std::filesystem::directory_iterator(folder.path())->path())
                       ->path();
  CHECK(ParsedJson::parse(std::ifstream(run / "policy.json")) == ParsedJson{{"checkpoint", "a"}});

  options.output = nullptr;
  policy.told = {R"({"checkpoint": "a"})", R"({"checkpoint": "b"})"};
  char* text = nullptr;
  CHECK(engram_evaluate(&options, act, &policy, &text) == ENGRAM_UNAVAILABLE);
  CHECK_THAT(engram_last_error(), Catch::Contains(R"(tells checkpoint "b", and told "a" before)"));
  policy.told = {"[]"};
  evaluated(options, act, &policy);
  CHECK(policy.status == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_policy_identify(nullptr, "{}") == ENGRAM_INVALID_ARGUMENT);
}

TEST_CASE("C API: an evaluation has a physics", "[evaluation][mujoco_physics]") {
  engram_evaluation_options options = engram::test::evaluation_options(1);
  Call call;
  CHECK_FALSE(evaluated(options, still, &call)["tasks"][0].contains("physics"));
  options.physics = ENGRAM_PHYSICS_MUJOCO;
  CHECK(evaluated(options, still, &call)["tasks"][0]["physics"] == "mujoco");
  options.physics = 2;
  char* text = nullptr;
  CHECK(engram_evaluate(&options, still, &call, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK_THAT(engram_last_error(), Catch::Contains("physics: 2 given, 0 to 1 allowed"));
}

TEST_CASE("C API: suites are named lists of tasks", "[evaluation]") {
  const ParsedJson suites = ParsedJson::parse(engram_suites_json());
  CHECK(suites["mikasa5"]["ids"].size() == 5);
  CHECK(suites["mikasa5"]["episodes"] == 100);
  CHECK(suites["mikasa5"]["seed"] == 4242424242);
}

TEST_CASE("C API: a callback is evaluated", "[evaluation]") {
  const engram_evaluation_options options = engram::test::evaluation_options(3);
  Call call;
  const ParsedJson document = evaluated(options, still, &call);
  const ParsedJson& task = document["tasks"][0];
  CHECK(task["env_id"] == engram::test::kId);
  CHECK(task["obs_mode"] == "state");
  CHECK(task["action_chunk_size"] == 4);
  CHECK(task["model"]["name"] == "external");
  CHECK(task["episode_lengths"] == std::vector<int>(3, 25));
  CHECK(call.requests >= 7);
  CHECK(document["summary"]["tasks"][0] == engram::test::kId);
}

TEST_CASE("C API: a policy may observe objects", "[evaluation][objects]") {
  engram_evaluation_options options = engram::test::evaluation_options(2);
  options.obs_mode = ENGRAM_OBS_OBJECTS;
  const auto policy = [](void* user, const engram_policy_request* request,
                         engram_policy_reply* reply) {
    CHECK(request->rgb == nullptr);
    // Three tokens, of which the cue shows one.
    REQUIRE(request->state_dim == 25 + 3 * 42);
    for (int32_t row = 0; row < request->count; ++row) {
      const float* tokens = request->state + row * request->state_dim + 25;
      if (request->steps[row] == 0) CHECK(tokens[0] + tokens[42] + tokens[84] == 1);
    }
    return still(user, request, reply);
  };
  Call call;
  const ParsedJson document = evaluated(options, policy, &call);
  CHECK(document["tasks"][0]["obs_mode"] == "objects");
  CHECK(call.requests >= 7);

  options.obs_mode = ENGRAM_OBS_OBJECTS_DICT;
  char* text = nullptr;
  CHECK(engram_evaluate(&options, policy, &call, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK_THAT(engram_last_error(), Catch::Contains("ENGRAM_OBS_OBJECTS allowed"));
}

TEST_CASE("C API: results name the rule set", "[evaluation][rules]") {
  for (const bool original : {false, true}) {
    engram_evaluation_options options = engram::test::evaluation_options(1);
    if (original) options.rules = ENGRAM_RULES_ORIGINAL;
    Call call;
    const ParsedJson document = evaluated(options, still, &call);
    CHECK(document["tasks"][0]["rules"] == (original ? "original" : "reference"));
  }
}

TEST_CASE("C API: a policy's name may be any bytes", "[evaluation]") {
  engram_evaluation_options options = engram::test::evaluation_options(1);
  options.name = "caf\xe9";
  Call call;
  const ParsedJson document = evaluated(options, still, &call);
  CHECK(document["tasks"][0]["model"]["name"] == "caf\xef\xbf\xbd");
}

TEST_CASE("C API: an evaluation that cannot be says why", "[evaluation]") {
  Call call;
  char* text = nullptr;
  const auto refused = [&](const engram_evaluation_options& options, engram_status status,
                           const std::string& words) {
    CHECK(engram_evaluate(&options, &still, &call, &text) == status);
    CHECK(text == nullptr);
    CHECK_THAT(engram_last_error(), Catch::Contains(words));
  };
  engram_evaluation_options options = engram::test::evaluation_options(0);
  refused(options, ENGRAM_INVALID_ARGUMENT, "episodes: 0 given");
  options = engram::test::evaluation_options(1);
  options.num_ids = 0;
  refused(options, ENGRAM_INVALID_ARGUMENT, "ids");
  options = engram::test::evaluation_options(1);
  options.rules = -1;
  refused(options, ENGRAM_INVALID_ARGUMENT, "rules: -1 given, 0 to 1 allowed");
  options = engram::test::evaluation_options(1);
  options.num_task_options = 1;
  refused(options, ENGRAM_INVALID_ARGUMENT, "task_options: NULL given, 1 values needed");
  const engram_task_option nameless = {nullptr, 1};
  options.task_options = &nameless;
  refused(options, ENGRAM_INVALID_ARGUMENT, "name of a task option: NULL given");
  options = engram::test::evaluation_options(1);
  const engram_perturbation beyond = {"light", 2};
  options.perturbations = &beyond;
  options.num_perturbations = 1;
  refused(options, ENGRAM_INVALID_ARGUMENT, "perturbation 'light': level 2 given");
  options = engram::test::evaluation_options(1);
  const std::string deep = "{\"a\":" + std::string(300'000, '[') + std::string(300'000, ']') + "}";
  options.config_json = deep.c_str();
  refused(options, ENGRAM_INVALID_ARGUMENT, "config_json: a JSON object needed");
  options = engram::test::evaluation_options(1);
  options.output = "/proc/nowhere";
  refused(options, ENGRAM_IO, "/proc/nowhere");
  options = engram::test::evaluation_options(1);
  call.shape[1] = 0;
  refused(options, ENGRAM_UNAVAILABLE, "empty chunk");
  CHECK(call.status == ENGRAM_INVALID_ARGUMENT);
  call = {};
  call.ndim = 4;
  refused(options, ENGRAM_UNAVAILABLE, "4 dimensions");
  call = {};
  options.progress = [](void*, int32_t, int32_t, uint64_t) { return 1; };
  options.episodes = 2000;
  refused(options, ENGRAM_UNAVAILABLE, "progress callback");
}

TEST_CASE("C API: rounds with policy seeds, and latency", "[evaluation][latency]") {
  engram_evaluation_options options = engram::test::evaluation_options(2);
  CHECK(options.repeat == 1);
  CHECK(options.policy_seed == 0);
  CHECK(options.latency == nullptr);
  options.repeat = 2;
  options.policy_seed = UINT64_MAX;
  options.latency = "60ms";
  const auto policy = [](void* user, const engram_policy_request* request,
                         engram_policy_reply* reply) {
    // The round after the largest seed has 0.
    static_cast<std::vector<uint64_t>*>(user)->push_back(request->policy_seed);
    const float action[7] = {0, 0, request->policy_seed == 0 ? 0.5F : -0.5F, 0, 0, 0, 0};
    const int64_t shape[] = {7};
    for (int32_t row = 0; row < request->count; ++row) {
      if (engram_policy_set(reply, row, action, shape, 1) != ENGRAM_OK) return 1;
    }
    return 0;
  };
  std::vector<uint64_t> seeds;
  const ParsedJson task = evaluated(options, policy, &seeds)["tasks"][0];
  CHECK(std::ranges::count(seeds, 0U) + std::ranges::count(seeds, UINT64_MAX) ==
        static_cast<std::ptrdiff_t>(seeds.size()));
  CHECK(task["n_episodes"] == 4);
  CHECK(task["latency_steps"] == 2);
  CHECK(task["policy_seed"] == UINT64_MAX);
  CHECK(task["returns"][0] != task["returns"][2]);
  CHECK(task["episode_seeds"][0] == task["episode_seeds"][2]);
  options.latency = "soon";
  char* text = nullptr;
  CHECK(engram_evaluate(&options, policy, &seeds, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK_THAT(engram_last_error(), Catch::Contains("latency: 'soon' given"));
  options.latency = nullptr;
  options.repeat = 0;
  CHECK(engram_evaluate(&options, policy, &seeds, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK_THAT(engram_last_error(), Catch::Contains("repeat: 0 given, 1 to 1000 allowed"));
}

TEST_CASE("C API: results are compared and tabulated", "[evaluation][compare]") {
  const engram_evaluation_options options = engram::test::evaluation_options(3);
  Call call;
  char* results = nullptr;
  REQUIRE(engram_evaluate(&options, &still, &call, &results) == ENGRAM_OK);
  char* text = nullptr;
  REQUIRE(engram_compare(results, results, nullptr, 0, &text) == ENGRAM_OK);
  CHECK(ParsedJson::parse(text)["total"]["pairs"] == 3);
  engram_free_text(text);
  REQUIRE(engram_report(results, "csv", &text) == ENGRAM_OK);
  CHECK_THAT(text, Catch::Contains("RememberColor3-VLA-v0,Short,Object,3,0.0,"));
  engram_free_text(text);
  const char* const unknown[] = {"everything"};
  CHECK(engram_compare(results, results, unknown, 1, &text) == ENGRAM_UNKNOWN_ID);
  CHECK(text == nullptr);
  CHECK_THAT(engram_last_error(), Catch::Contains("ids, seeds, version, rules, constants"));
  CHECK(engram_report(results, "word", &text) == ENGRAM_UNKNOWN_ID);
  CHECK(engram_report("/nowhere", "md", &text) == ENGRAM_IO);
  CHECK(engram_report("{}", "md", &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_compare(nullptr, results, nullptr, 0, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_compare(results, results, nullptr, 1, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_report(results, nullptr, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_report(results, "md", nullptr) == ENGRAM_INVALID_ARGUMENT);
  engram_free_text(results);
}

TEST_CASE("C API: shards of an evaluation merge to the document of one process", "[evaluation]") {
  Call call;
  engram_evaluation_options options = engram::test::evaluation_options(5);
  const ParsedJson one = evaluated(options, &still, &call);
  const engram::test::TemporaryFolder folder;
  const std::string out = folder.path().string();
  const char* const folders[] = {out.c_str()};
  char* text = nullptr;
  CHECK(engram_merge(folders, 1, nullptr, &text) == ENGRAM_INVALID_ARGUMENT);
  options.output = out.c_str();
  options.shard = "2/2";
  CHECK(evaluated(options, &still, &call) ==
        ParsedJson({{"shard", "2/2"}, {"out", out + "/shard-2-of-2"}, {"episodes", 2}}));
  CHECK(engram_merge(folders, 1, nullptr, &text) == ENGRAM_UNAVAILABLE);
  CHECK_THAT(engram_last_error(), Catch::Contains("1 of 2 shards not finished; the first is 1/2, "
                                                  "without 3 episodes"));
  options.shard = "1/2";
  CHECK(evaluated(options, &still, &call)["episodes"] == 3);
  const int before = call.requests;
  CHECK(evaluated(options, &still, &call)["episodes"] == 3);  // nothing is missing
  CHECK(call.requests == before);
  REQUIRE(engram_merge(folders, 1, nullptr, &text) == ENGRAM_OK);
  CHECK(ParsedJson::parse(text) == one);
  engram_free_text(text);
}

TEST_CASE("C API: bad shards are refused", "[evaluation]") {
  Call call;
  engram_evaluation_options options = engram::test::evaluation_options(2);
  const auto refused = [&](const char* words) {
    char* text = nullptr;
    CHECK(engram_evaluate(&options, &still, &call, &text) == ENGRAM_INVALID_ARGUMENT);
    CHECK_THAT(engram_last_error(), Catch::Contains(words));
  };
  options.shard = "1/2";
  refused("shard: given without output");
  options.output = "folder";
  options.resume = "other";
  refused("or with resume");
  options.resume = nullptr;
  options.shard = "3/2";
  refused("shard: '3/2' given, I/N with I from 1 to N");
  char* text = nullptr;
  CHECK(engram_probe(&options, nullptr, nullptr, &still, &call, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK_THAT(engram_last_error(), Catch::Contains("shard: given"));
  const char* const folders[] = {"/nowhere", nullptr};
  CHECK(engram_merge(folders, 1, nullptr, &text) == ENGRAM_IO);
  CHECK(engram_merge(folders, 0, nullptr, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_merge(folders, 2, nullptr, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_merge(folders, 1, "", &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_merge(nullptr, 1, nullptr, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_merge(folders, 1, nullptr, nullptr) == ENGRAM_INVALID_ARGUMENT);
  CHECK(call.requests == 0);
}

namespace {

struct Choosing {
  int questions = 0;
  int32_t index = 0;              // of the choice
  const char* text = nullptr;     // instead
  const char* failure = nullptr;  // instead
  engram_status status = ENGRAM_OK;
  std::string words;  // of the first frame
};

int choose(void* user, const engram_choice_question* question, engram_choice_answer* answer) {
  auto& call = *static_cast<Choosing*>(user);
  ++call.questions;
  REQUIRE(question->struct_size == sizeof *question);
  CHECK(question->num_choices == 3);
  CHECK(question->least == 1);
  CHECK(question->most == 1);
  CHECK(question->repeats == 0);
  CHECK(question->index == 0);
  CHECK(question->frame_steps[0] == 0);
  CHECK(question->frame_steps[question->num_frames - 1] == question->step);
  CHECK(question->rgb == nullptr);
  CHECK(question->seed == nullptr);
  if (question->texts != nullptr) call.words = question->texts[0];
  if (call.failure != nullptr) {
    engram_choice_fail(answer, call.failure);
    return 1;
  }
  call.status = call.text != nullptr ? engram_choose_texts(answer, &call.text, 1)
                                     : engram_choose(answer, &call.index, 1);
  if (call.status == ENGRAM_OK) return 0;
  engram_choice_fail(answer, engram_last_error());
  return 1;
}

}  // namespace

TEST_CASE("C API: a policy names answers", "[evaluation][choices]") {
  engram_evaluation_options options = engram::test::evaluation_options(3);
  options.obs_mode = ENGRAM_OBS_OBJECTS;
  Choosing call;
  char* text = nullptr;
  REQUIRE(engram_evaluate_choices(&options, &choose, &call, &text) == ENGRAM_OK);
  const ParsedJson by_index = ParsedJson::parse(text);
  engram_free_text(text);
  CHECK(call.questions == 3);
  CHECK_THAT(call.words, Catch::Contains("cube at x "));
  CHECK(by_index["tasks"][0]["choices"] == true);
  call.text = "0";
  REQUIRE(engram_evaluate_choices(&options, &choose, &call, &text) == ENGRAM_OK);
  CHECK(ParsedJson::parse(text) == by_index);
  engram_free_text(text);
}

TEST_CASE("C API: choices of another form are refused", "[evaluation][choices]") {
  engram_evaluation_options options = engram::test::evaluation_options(1);
  char* text = nullptr;
  Choosing call;
  call.index = 3;
  CHECK(engram_evaluate_choices(&options, &choose, &call, &text) == ENGRAM_UNAVAILABLE);
  CHECK(call.status == ENGRAM_INVALID_ARGUMENT);
  CHECK_THAT(engram_last_error(), Catch::Contains("choice 3 given, 0 to 2 allowed"));
  call.text = "the pink cube";
  CHECK(engram_evaluate_choices(&options, &choose, &call, &text) == ENGRAM_UNAVAILABLE);
  CHECK_THAT(engram_last_error(), Catch::Contains("choice 'the pink cube' given"));
  call.failure = "no idea";
  CHECK(engram_evaluate_choices(&options, &choose, &call, &text) == ENGRAM_UNAVAILABLE);
  CHECK_THAT(engram_last_error(), Catch::Contains("policy: no idea"));
  const auto silent = [](void*, const engram_choice_question*, engram_choice_answer*) { return 0; };
  CHECK(engram_evaluate_choices(&options, silent, nullptr, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK_THAT(engram_last_error(), Catch::Contains("no choice given"));
  CHECK(engram_choose(nullptr, nullptr, 0) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_choose_texts(nullptr, nullptr, 0) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_choice_fail(nullptr, "x") == ENGRAM_INVALID_ARGUMENT);
  CHECK(text == nullptr);
}

TEST_CASE("C API: choices are refused where there are none", "[evaluation][choices]") {
  const char* const ids[] = {"InterceptSlow-VLA-v0"};
  engram_evaluation_options options = engram::test::evaluation_options(1);
  Choosing call;
  char* text = nullptr;
  options.choices_stride = 0;
  CHECK(engram_evaluate_choices(&options, &choose, &call, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK_THAT(engram_last_error(), Catch::Contains("choices_stride: 0 given, 1 to"));
  options.choices_stride = 1;
  options.ids = ids;
  CHECK(engram_evaluate_choices(&options, &choose, &call, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK_THAT(engram_last_error(), Catch::Contains("InterceptSlow-VLA-v0 has no list of answers"));
  CHECK(engram_evaluate_choices(&options, nullptr, &call, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK(call.questions == 0);
}

TEST_CASE("C API: a probe asks the callback, and says what it has found", "[evaluation][probe]") {
  Call call;
  engram_evaluation_options options = engram::test::evaluation_options(2);
  options.obs_mode = ENGRAM_OBS_OBJECTS;
  char* text = nullptr;
  REQUIRE(engram_probe(&options, "twins,interference", nullptr, &still, &call, &text) == ENGRAM_OK);
  const ParsedJson document = ParsedJson::parse(text);
  engram_free_text(text);
  CHECK(call.requests > 0);
  const ParsedJson& twins = document["tasks"][0]["twins"];
  CHECK(twins["pairs"] == 2);
  CHECK(twins["presents"]["equal"] == twins["presents"]["compared"]);
  CHECK(twins["follow"]["rate"] == 0.0);
  CHECK(document["tasks"][0]["interference"]["points"].size() == 7);

  const int before = call.requests;
  CHECK(engram_probe(nullptr, nullptr, nullptr, &still, &call, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_probe(&options, nullptr, nullptr, nullptr, &call, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_probe(&options, nullptr, nullptr, &still, &call, nullptr) ==
        ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_probe(&options, "twin", nullptr, &still, &call, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_probe(&options, nullptr, "None-v0", &still, &call, &text) == ENGRAM_UNKNOWN_ID);
  options.resume = "folder";
  CHECK(engram_probe(&options, nullptr, nullptr, &still, &call, &text) == ENGRAM_INVALID_ARGUMENT);
  CHECK(text == nullptr);
  CHECK(call.requests == before);
}
