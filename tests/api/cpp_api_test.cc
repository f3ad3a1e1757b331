// The C++ header as users see it. Nothing else of the library is included here.
#include <array>
#include <catch2/catch.hpp>
#include <utility>

#include "engram/engram.h"

namespace {

using Catch::Matchers::Contains, engram::AutoReset, engram::EnvOptions, engram::Error,
    engram::ObsMode, engram::Policy, engram::VectorEnv;

constexpr const char* kId = "RememberColor3-VLA-v0";

// The kind of what f throws; the message must have `part` in it.
template <class F>
Error::Kind kind_of(F&& f, const char* part) {
  try {
    f();
  } catch (const Error& error) {
    CHECK_THAT(error.what(), Catch::Matchers::Contains(part));
    return error.kind();
  }
  FAIL("nothing was thrown");
  return Error::Kind::kInternal;
}

VectorEnv make_running(const EnvOptions& options) {
  VectorEnv env = engram::make(kId, options);
  env.reset();
  return env;
}

TEST_CASE("The oracle succeeds through the C++ header", "[cpp_api]") {
  VectorEnv env = make_running({.num_envs = 8, .seed = 3, .auto_reset = AutoReset::kOff});
  std::vector<float> actions = env.make_actions();
  CHECK(actions.size() == 56);
  for (int i = 0; i < env.horizon(); ++i) {
    env.act(Policy::kOracle, actions);
    env.step(actions);
  }
  int successes = 0;
  for (const std::uint8_t success : env.success_once()) successes += success;
  CHECK(successes >= 7);
  CHECK(env.episode_return()[0] > 0);
  CHECK(env.elapsed_steps()[0] > 5);
}

TEST_CASE("Views have one row per environment", "[cpp_api]") {
  const VectorEnv env = make_running({.num_envs = 3, .threads = 1});
  CHECK(env.id() == kId);
  CHECK(env.num_threads() == 1);
  CHECK(env.observation().size() == 3 * static_cast<std::size_t>(env.state_dim()));
  CHECK(env.proprio().size() == 21);
  CHECK(env.reward().size() == 3);
  CHECK(env.terminated().size() == 3);
  CHECK(env.truncated().size() == 3);
  CHECK(env.success().size() == 3);
  CHECK(env.unstable().size() == 3);
  CHECK(env.final_mask().size() == 3);
  CHECK(env.rgb().empty());
  CHECK(env.action_low()[0] == -1);
  CHECK(env.action_high().size() == 7);
  CHECK(env.unstable_count() == 0);
  CHECK_FALSE(env.instruction(2).empty());
  CHECK(env.instruction(2).back() == '.');
  CHECK(env.words(2).find("\"subtasks_done\": 0") != std::string::npos);
}

TEST_CASE("Outputs are typed views with their shape", "[cpp_api]") {
  const VectorEnv env = make_running({.num_envs = 3, .pins = {{"target", {1}}}});
  const engram::Output oracle = env.output("oracle_info");
  CHECK(oracle.shape == std::vector<std::int64_t>{3});
  CHECK(oracle.row<std::int32_t>(2)[0] == 1);
  const engram::Output position = env.output("obj_to_goal_pos");
  CHECK(position.width() == 3);
  CHECK(position.values<float>().size() == 9);
  CHECK(env.output("proprio").unit == "m, rad");
  CHECK(env.outputs().size() > 10);
  CHECK(kind_of([&] { position.values<double>(); }, "obj_to_goal_pos") ==
        Error::Kind::kInvalidArgument);
  CHECK(kind_of([&] { position.row<float>(3); }, "0 to 2") == Error::Kind::kInvalidArgument);
  CHECK(kind_of([&] { env.output("colour"); }, "reward") == Error::Kind::kUnknownId);
  CHECK(kind_of([&] { env.final_output("reward"); }, "same-step") == Error::Kind::kBadState);
}

TEST_CASE("Options arrive", "[cpp_api]") {
  const VectorEnv env =
      make_running({.num_envs = 2,
                    .obs_mode = ObsMode::kRgb,
                    .reward_mode = engram::RewardMode::kSparse,
                    .control_mode = engram::ControlMode::kPdEeDeltaPos,
                    .rules = engram::Rules::kOriginal,
                    .images = {.width = 8, .height = 6, .cameras = {"hand_camera"}}});
  CHECK(env.action_dim() == 4);
  CHECK(env.rgb().size() == 2 * 8 * 6 * 3);
  CHECK(env.observation().empty());
  CHECK(env.describe().find("\"control_mode\": \"pd_ee_delta_pos\"") != std::string_view::npos);
  CHECK(env.describe().find("\"rules\": \"original\"") != std::string_view::npos);

  const auto refused = [](const EnvOptions& options, const char* part) {
    return kind_of([&] { engram::make(kId, options); }, part);
  };
  CHECK(refused({.num_envs = 0}, "num_envs: 0") == Error::Kind::kInvalidArgument);
  CHECK(refused({.pins = {{"target", {3}}}}, "target") == Error::Kind::kInvalidArgument);
  CHECK(refused({.task_options = {{"gravity", 1}}}, "gravity") == Error::Kind::kUnknownId);
  CHECK(refused({.perturbations = {{"smell", 1}}}, "smell") == Error::Kind::kUnknownId);
  CHECK(refused({.obs_mode = ObsMode::kRgb, .images = {.cameras = {}}}, "camera") ==
        Error::Kind::kInvalidArgument);
  CHECK(refused({.obs_mode = static_cast<ObsMode>(17)}, "obs_mode") ==
        Error::Kind::kInvalidArgument);
  CHECK(refused({.rules = static_cast<engram::Rules>(9)}, "rules: 9 given, 0 to 1 allowed") ==
        Error::Kind::kInvalidArgument);
  CHECK(kind_of([] { engram::make("RememberColor"); }, "did you mean") == Error::Kind::kUnknownId);
}

TEST_CASE("Depth and segmentation lie beside colours", "[cpp_api]") {
  const engram::ImageOptions images = {.width = 8, .height = 6};
  const auto seeing = [&](ObsMode mode) {
    return make_running({.num_envs = 2, .obs_mode = mode, .images = images});
  };
  const VectorEnv rgb = seeing(ObsMode::kRgb);
  const VectorEnv depth = seeing(ObsMode::kRgbDepth);
  const VectorEnv segmentation = seeing(ObsMode::kRgbSegmentation);
  const VectorEnv both = seeing(ObsMode::kRgbDepthSegmentation);
  for (const VectorEnv* env : {&depth, &segmentation, &both}) {
    CHECK(std::ranges::equal(env->rgb(), rgb.rgb()));
    CHECK(env->observation().empty());
  }
  CHECK(rgb.depth().empty());
  CHECK(rgb.segmentation().empty());
  CHECK(depth.segmentation().empty());
  CHECK(segmentation.depth().empty());
  CHECK(both.depth().size() == 2 * 6 * 8 * 2);
  CHECK(std::ranges::equal(both.depth(), depth.depth()));
  CHECK(std::ranges::equal(both.segmentation(), segmentation.segmentation()));
  const engram::Output output = both.output("depth");
  CHECK(output.dtype == engram::DType::kInt16);
  CHECK(output.shape == std::vector<std::int64_t>{2, 6, 8, 2});
  CHECK(output.values<std::int16_t>().data() == both.depth().data());
  CHECK(kind_of([&] { output.values<std::uint8_t>(); }, "depth") == Error::Kind::kInvalidArgument);
  CHECK(both.describe().find("\"background\"") != std::string_view::npos);
  CHECK(depth.describe().find("\"segmentation_names\": []") != std::string_view::npos);
}

TEST_CASE("Images and rows come together in C++", "[cpp_api]") {
  const auto seen = [](ObsMode mode) {
    return make_running({.num_envs = 2, .obs_mode = mode, .images = {.width = 8, .height = 6}});
  };
  const VectorEnv images = seen(ObsMode::kRgbDepth);
  for (const auto& [mode, row] : {std::pair(ObsMode::kRgbDepthState, ObsMode::kState),
                                  std::pair(ObsMode::kRgbDepthObjects, ObsMode::kObjects)}) {
    const VectorEnv both = seen(mode);
    CHECK(std::ranges::equal(both.rgb(), images.rgb()));
    CHECK(std::ranges::equal(both.depth(), images.depth()));
    CHECK(both.segmentation().empty());
    CHECK(both.observation().size() > 0);
    CHECK(std::ranges::equal(both.observation(), seen(row).observation()));
  }
}

TEST_CASE("Objects are rows of what the description names", "[cpp_api][objects]") {
  VectorEnv env = make_running({.num_envs = 2, .obs_mode = ObsMode::kObjects});
  VectorEnv named = make_running({.num_envs = 2, .obs_mode = ObsMode::kObjectsDict});
  const VectorEnv timed =
      make_running({.num_envs = 2, .obs_mode = ObsMode::kObjects, .observe_time = true});
  CHECK(timed.state_dim() == env.state_dim() + 1);
  CHECK(env.observation().size() == 2 * static_cast<std::size_t>(env.state_dim()));
  CHECK(env.output("observation").width() == static_cast<std::size_t>(env.state_dim()));
  CHECK(env.describe().find("\"object_2_color\"") != std::string_view::npos);
  CHECK(env.describe() == named.describe());
  std::vector<float> actions = env.make_actions();
  for (int i = 0; i < 8; ++i) {
    CHECK(std::equal(env.observation().begin(), env.observation().end(),
                     named.observation().begin(), named.observation().end()));
    env.act(Policy::kRandom, actions);
    env.step(actions);
    named.step(actions);
  }
  const std::vector<float> before(env.observation().begin(), env.observation().end());
  const auto saved = env.save();
  env.step(actions);
  CHECK_FALSE(std::equal(before.begin(), before.end(), env.observation().begin()));
  env.restore(saved);
  CHECK(std::equal(before.begin(), before.end(), env.observation().begin()));
}

TEST_CASE("Every control mode of the header is one of the library", "[cpp_api]") {
  const std::array<int, 11> dims = {8, 8, 4, 7, 7, 8, 4, 7, 8, 15, 15};
  for (std::size_t i = 0; i < dims.size(); ++i) {
    const VectorEnv env = engram::make(kId, {.control_mode = static_cast<engram::ControlMode>(i)});
    CHECK(env.action_dim() == dims[i]);
  }
}

TEST_CASE("Halves of a step, and what is refused between them", "[cpp_api][async]") {
  VectorEnv whole = make_running({.num_envs = 4, .seed = 5});
  VectorEnv halves = make_running({.num_envs = 4, .seed = 5});
  std::vector<float> actions = whole.make_actions();
  for (int i = 0; i < 10; ++i) {
    whole.act(Policy::kRandom, actions);
    whole.step(actions);
    halves.step_async(actions);
    if (i == 3) {
      CHECK(kind_of([&] { halves.step(actions); }, "under way") == Error::Kind::kBadState);
    }
    halves.step_wait();
    CHECK(std::equal(whole.observation().begin(), whole.observation().end(),
                     halves.observation().begin()));
  }
  halves.step_async(actions);  // the destructor waits
}

TEST_CASE("Resets take masks, seeds and pins", "[cpp_api]") {
  VectorEnv env = make_running({.num_envs = 2});
  const std::array<std::uint8_t, 2> mask = {0, 1};
  const std::array<std::uint64_t, 2> seeds = {0, 77};
  env.reset({.mask = mask, .seeds = seeds, .pins = std::vector<engram::Pin>{{"target", {2}}}});
  CHECK(env.output("oracle_info").row<std::int32_t>(1)[0] == 2);
  const VectorEnv other = make_running({.seed = 77, .pins = {{"target", {2}}}});
  CHECK(std::equal(other.observation().begin(), other.observation().end(),
                   env.output("observation").row<float>(1).begin()));
  const std::array<std::uint8_t, 3> long_mask = {1, 1, 1};
  CHECK(kind_of([&] { env.reset({.mask = long_mask}); }, "2 needed") ==
        Error::Kind::kInvalidArgument);
  CHECK(kind_of(
            [&] {
              env.reset({.pins = std::vector<engram::Pin>{{"colour", {2}}}});
            },
            "colour") == Error::Kind::kUnknownId);
}

TEST_CASE("Snapshots of one environment and of all", "[cpp_api]") {
  VectorEnv env = make_running({.num_envs = 3});
  const engram::Snapshot all = env.save();
  const engram::Snapshot one = env.save(2);
  const std::vector<float> before(env.observation().begin(), env.observation().end());
  env.reset();
  env.restore(0, one);
  const auto row = static_cast<std::ptrdiff_t>(env.state_dim());
  CHECK(std::equal(before.begin() + 2 * row, before.end(), env.observation().begin()));
  env.restore(all);
  CHECK(std::equal(before.begin(), before.end(), env.observation().begin()));
  CHECK(kind_of([&] { (void)env.save(-1); }, "0 to 2") == Error::Kind::kInvalidArgument);
  CHECK(kind_of([&] { env.restore(-1, one); }, "0 to 2") == Error::Kind::kInvalidArgument);
}

TEST_CASE("Images for people and of sensors", "[cpp_api]") {
  const VectorEnv env = make_running({});
  const engram::Image image = env.render(0, "render_camera", 20, 10);
  CHECK(image.rgb.size() == 600);
  CHECK(env.render(0, "hand_camera", 20, 10).rgb != image.rgb);
  CHECK(kind_of([&] { (void)env.render(0, "base_camera", -1, 10); }, "4096") ==
        Error::Kind::kInvalidArgument);
}

TEST_CASE("Robot, cameras and drawn values on demand", "[cpp_api][queries]") {
  VectorEnv env =
      engram::make("TimedTransferEasy-VLA-v0", {.num_envs = 2, .pins = {{"signal_step", {3}}}});
  std::vector<float> qpos(18);
  std::vector<float> tcp(14);
  CHECK_THROWS_WITH(env.robot_state(qpos, {}, tcp), Contains("before the first reset"));
  env.reset();
  env.robot_state(qpos, {}, tcp);
  CHECK(tcp[7] == env.proprio()[7]);
  CHECK(qpos[17] == Approx(0.04));
  CHECK_THROWS_WITH(env.robot_state(tcp, {}, {}), Contains("qpos: 14 values given, 18 needed"));

  std::vector<float> pose(32);
  env.camera_params("base_camera", 64, 64, {.cam2world_gl = pose});
  CHECK(pose[16 + 11] == Approx(0.6));  // its height
  CHECK_THROWS_WITH(env.camera_params("top", 64, 64, {}), Contains("base_camera"));

  REQUIRE(env.drawn_dim() == 3);
  std::vector<float> drawn(6);
  env.drawn(drawn);
  CHECK(drawn[3] == 3);
  drawn.pop_back();
  CHECK_THROWS_WITH(env.drawn(drawn), Contains("5 values given, 6 needed"));
}

TEST_CASE("Shadows in images for people are an option", "[cpp_api]") {
  const VectorEnv plain = make_running({});
  const VectorEnv shadowed = make_running({.render_shadows = true});
  const engram::Image lit = plain.render(0, "render_camera", 40, 40);
  const engram::Image dark = shadowed.render(0, "render_camera", 40, 40);
  int darker = 0;
  for (std::size_t i = 0; i < lit.rgb.size(); ++i) {
    CHECK(dark.rgb[i] <= lit.rgb[i] + 1);
    darker += dark.rgb[i] + 10 < lit.rgb[i] ? 1 : 0;
  }
  CHECK(darker > 30);
  CHECK(plain.render(0, "base_camera", 40, 40).rgb ==
        shadowed.render(0, "base_camera", 40, 40).rgb);
}

TEST_CASE("A batch moves, and its views stay", "[cpp_api]") {
  VectorEnv first = make_running({.num_envs = 2});
  const float* data = first.observation().data();
  VectorEnv second = std::move(first);
  second.step(second.make_actions());
  CHECK(second.observation().data() == data);
  CHECK(kind_of([&] { first.reset(); }, "NULL") == Error::Kind::kInvalidArgument);  // NOLINT
  first = engram::make(kId);
  first.reset();
  CHECK(first.num_envs() == 1);
}

TEST_CASE("Texts with a character 0 are refused, not cut off there", "[cpp_api]") {
  const std::string cut = std::string("target") + '\0' + "2";
  const std::string id = std::string(kId) + '\0' + "-and-more";
  const auto refuses = [](auto&& f) {
    CHECK(kind_of(f, "character 0 given") == Error::Kind::kInvalidArgument);
  };
  refuses([&] { engram::make(id); });
  refuses([&] { engram::make(kId, {.pins = {{cut, {1}}}}); });
  refuses([&] { engram::make(kId, {.constants = std::string("{}") + '\0'}); });
  refuses([&] { engram::make(kId, {.task_options = {{cut, 1}}}); });
  refuses([&] { engram::load_variants(std::string("/dev/null") + '\0' + ".json"); });
  refuses([&] { engram::register_variant({id, kId, {}, {}}); });
  VectorEnv env = make_running({.num_envs = 1});
  refuses([&] { (void)env.output(std::string("reward") + '\0'); });
  refuses([&] { (void)env.render(0, std::string("base_camera") + '\0', 8, 8); });
  refuses([&] { env.reset({.pins = std::vector<engram::Pin>{{cut, {1}}}}); });
  env.step(env.make_actions());
}

TEST_CASE("The header lists the tasks", "[cpp_api]") {
  CHECK(engram::task_ids().size() == engram_num_tasks());
  CHECK(engram::task_ids().front() == "ShellGameTouch-VLA-v0");
  CHECK(engram::list().find("RememberColor9-VLA-v0") != std::string_view::npos);
  CHECK(engram::version() == engram_version());
}

TEST_CASE("The header makes batches of several tasks, and writes to arrays of the caller's",
          "[cpp_api]") {
  constexpr const char* kOther = "ShellGameTouch-VLA-v0";
  VectorEnv env = engram::make_group(
      {{kId, 2}, {kOther, 3}},
      {.seed = 4, .obs_mode = ObsMode::kRgb, .images = {.width = 16, .height = 16}});
  CHECK(env.id() == std::string(kId) + "+" + kOther);
  REQUIRE(env.num_envs() == 5);
  std::vector<std::uint8_t> one(env.rgb().size());
  std::vector<std::uint8_t> other(one.size());
  const auto target = [](std::vector<std::uint8_t>& values) {
    return std::vector<engram::OutputTarget>{{"rgb", std::as_writable_bytes(std::span(values))}};
  };
  CHECK(kind_of(
            [&] {
              env.write_outputs({target(one), {{"reward", {}}, {"rgb", {}}}});
            },
            "turns of 1 and 2 arrays") == Error::Kind::kInvalidArgument);
  CHECK(kind_of([&] { env.write_outputs({}); }, "0 turns") == Error::Kind::kInvalidArgument);
  env.write_outputs({target(one), target(other)});
  env.reset();
  CHECK(env.rgb().data() == one.data());
  std::vector<float> actions = env.make_actions();
  env.act(Policy::kRandom, actions);
  env.step(actions);
  CHECK(env.rgb().data() == other.data());
  CHECK(env.output_buffer() == 1);
  CHECK(env.output("task_index").values<std::int32_t>()[4] == 1);
  CHECK(kind_of([&] { env.write_outputs({target(one)}); }, "after the first reset") ==
        Error::Kind::kBadState);
}

}  // namespace
