#include "tasks/take_it_back/task.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "protocol/make/make.h"
#include "tests/differing_pixels.h"
#include "tests/env_helpers.h"

namespace {

using namespace engram;
using test::ImagePair, test::make_env, test::make_running, test::row;

constexpr const char* kId = "TakeItBack-VLA-v0";
constexpr int kCube = 0;
constexpr int kInitialRegion = 1;
constexpr int kGoalRegion = 2;
constexpr int kChangedRegion = 3;

std::vector<Pin> pins(double slot = 0, double x = 0) {
  return {{"slot", {slot}},
          {"initial_x", {x}},
          {"initial_shift", {0.02}},
          {"goal_x", {0.22}},
          {"goal_y", {0}}};
}

void put_cube(const Batch& batch, double x, double y) {
  double* pos = batch.state().prop_pos_of(0, kCube);
  pos[0] = x;
  pos[1] = y;
}

bool visible(const Batch& batch, int prop) {
  return batch.state().status_of(0, prop) != PropStatus::kHidden;
}

TEST_CASE("The reward of TakeItBack equals the worked examples", "[take_it_back]") {
  const auto reward = [](Eigen::Vector3d cube, Eigen::Vector3d tcp, bool reached, bool success) {
    tasks::TakeItBackReward in{.cube = cube,
                               .tcp = tcp,
                               .goal = {0.22, 0},
                               .initial = {0, 0.1},
                               .reached = reached,
                               .success = success};
    return in.compute();
  };
  const auto near = [](double value) { return Approx(value).margin(1e-6); };
  CHECK(reward({0, 0.1, 0.02}, {-0.0707, 0, 0.318}, false, false) == near(0.406005));
  CHECK(reward({0.1, 0.05, 0.02}, {0.07, 0.05, 0.02}, false, false) == near(4.734156));
  CHECK(reward({0.16, 0.02, 0.02}, {0.155, 0.02, 0.02}, true, false) == near(12.147684));
  CHECK(reward({0.12, 0.04, 0.02}, {0.15, 0.04, 0.02}, true, false) == near(19.504887));
  CHECK(reward({0.05, 0.08, 0.02}, {0.08, 0.08, 0.02}, false, false) == near(1.861028));
  CHECK(reward({0.05, 0.08, 0.02}, {0.08, 0.08, 0.02}, true, true) == 30);
}

TEST_CASE("The target changes colour one step after the cube was there, for good",
          "[take_it_back]") {
  const auto batch = make_running(kId, {.substeps = 0, .pins = pins()});
  const auto check = [&](bool achieved, bool reached, bool changed, bool success) {
    CHECK(*row<std::uint8_t>(batch->output("goal_achieved"), 0) == (achieved ? 1 : 0));
    CHECK(*row<std::uint8_t>(batch->output("goal_reached_status"), 0) == (reached ? 1 : 0));
    CHECK(visible(*batch, kGoalRegion) == !changed);
    CHECK(visible(*batch, kChangedRegion) == changed);
    CHECK(batch->state().prop_pos_of(0, kGoalRegion)[2] == (changed ? 1000 : 0.001));
    CHECK(batch->state().prop_pos_of(0, kChangedRegion)[2] == (changed ? 0.001 : 1000));
    CHECK(batch->outputs().success[0] == (success ? 1 : 0));
    const auto observation = batch->outputs().observation;
    CHECK(observation[25] == 0.22F);  // the target's place, whichever disc shows it
    CHECK(observation[27] == 0.001F);
    CHECK(observation[38] == (reached ? 1.0F : 0.0F));
    CHECK(batch->outputs().terminated[0] == 0);
  };
  const auto step = [&](double x, double y) {
    put_cube(*batch, x, y);
    test::step(*batch, Policy::kZero);
  };
  check(false, false, false, false);
  step(0.1, 0.0);
  check(false, false, false, false);
  step(0, 0.02);  // where it began, but it has not been there yet
  check(false, false, false, false);
  step(0.22 - 0.0801, 0);
  check(false, false, false, false);
  step(0.22 - 0.0799, 0);
  check(true, true, false, false);
  step(0.22, 0);
  check(true, true, true, false);
  step(0.1, 0);  // away again: the stage stays
  check(false, true, true, false);
  step(0, 0.02 + 0.0801);
  check(false, true, true, false);
  step(0, 0.02 + 0.0799);
  check(false, true, true, true);
  step(0.1, 0.05);
  check(false, true, true, false);
  CHECK(*row<std::uint8_t>(batch->output("success_once"), 0) == 1);
  batch->reset();
  check(false, false, false, false);
  CHECK(batch->state_dim() == 39);
}

TEST_CASE("A cube that passes the target in one step changes it in the next", "[take_it_back]") {
  const auto batch = make_running(kId, {.substeps = 0, .pins = pins()});
  put_cube(*batch, 0.2, 0);
  test::step(*batch, Policy::kZero);
  CHECK(visible(*batch, kGoalRegion));
  put_cube(*batch, 0, 0.02);
  test::step(*batch, Policy::kZero);
  CHECK(visible(*batch, kChangedRegion));
  CHECK(batch->outputs().success[0] == 1);
}

TEST_CASE("Start and target cover their ranges and never overlap", "[take_it_back]") {
  BatchOptions options{.num_envs = 6000};
  const auto batch = make_running(kId, options);
  double nearest = 1;
  std::vector<int> slots(3);
  for (int i = 0; i < options.num_envs; ++i) {
    const double* start = batch->state().prop_pos_of(i, kInitialRegion);
    const double* goal = batch->state().prop_pos_of(i, kGoalRegion);
    nearest = std::min(nearest, std::hypot(start[0] - goal[0], start[1] - goal[1]));
    const int slot = static_cast<int>(std::floor((start[1] + 0.1) / 0.1));
    REQUIRE(slot >= 0);
    REQUIRE(slot <= 2);
    ++slots[static_cast<std::size_t>(slot)];
    REQUIRE(start[1] + 0.1 - 0.1 * slot < 0.05);
    REQUIRE(std::abs(start[0]) <= 0.05);
    REQUIRE(std::abs(goal[0] - 0.225) <= 0.025);
    REQUIRE(std::abs(goal[1]) <= 0.025);
    const double* cube = batch->state().prop_pos_of(i, kCube);
    REQUIRE(std::equal(cube, cube + 2, start));
    REQUIRE(row<float>(batch->output("oracle_info"), i)[1] == static_cast<float>(start[1]));
  }
  CHECK(nearest >= 0.16);
  CHECK(nearest < 0.165);
  for (const int count : slots) CHECK(std::abs(count - 2000) < 200);

  // Pins that leave no choice are obeyed.
  options.num_envs = 1;
  options.pins = {{"slot", {0}},
                  {"initial_x", {0.05}},
                  {"initial_shift", {0}},
                  {"goal_x", {0.2}},
                  {"goal_y", {0}}};
  const auto pinned = make_running(kId, options);
  CHECK(pinned->state().prop_pos_of(0, kGoalRegion)[0] == 0.2);
}

// About 0.2 % of all draws overlap.
TEST_CASE("With may_overlap, start and target are drawn once and overlap now and then",
          "[take_it_back]") {
  BatchOptions options{.num_envs = 6000};
  const auto guarded = make_env(kId, options);
  options.task_options = {{"may_overlap", 1}};
  const auto batch = make_env(kId, options);
  guarded->reset();
  batch->reset();
  int overlaps = 0;
  for (int i = 0; i < options.num_envs; ++i) {
    const double* start = batch->state().prop_pos_of(i, kInitialRegion);
    const double* goal = batch->state().prop_pos_of(i, kGoalRegion);
    const bool overlap = std::hypot(start[0] - goal[0], start[1] - goal[1]) < 0.16;
    overlaps += overlap ? 1 : 0;
    const double* usual = guarded->state().prop_pos_of(i, kGoalRegion);
    CHECK(std::equal(goal, goal + 2, usual) == !overlap);  // all others are as they were
  }
  CHECK(overlaps > 2);
  CHECK(overlaps < 30);
}

TEST_CASE("No sensor shows where the cube started", "[take_it_back][render]") {
  const auto start_at = [](double slot, double x) {
    const BatchOptions options{.substeps = 0};
    auto batch = make(kId, options);
    const std::vector<Pin> where = pins(slot, x);
    batch->reset({.mask = {}, .seeds = {}, .pins = &where});
    return batch;
  };
  const auto one = start_at(-1, -0.05);
  const auto other = start_at(1, 0.03);
  ImagePair images(*one, *other);
  CHECK(images.differing_pixels("base_camera") > 10);  // the cube itself
  for (const auto* env : {&one, &other}) put_cube(**env, 0.12, 0.01);
  CHECK(images.differing_pixels("base_camera") == 0);
  CHECK(images.differing_pixels("hand_camera") == 0);
  CHECK(images.differing_pixels("render_camera") > 100);  // people see the blue disc

  const BatchOptions options{.obs_mode = ObsMode::kRgb, .substeps = 0};
  const auto rgb = [&](double slot) {
    auto batch = make(kId, options);
    const std::vector<Pin> where = pins(slot);
    batch->reset({.mask = {}, .seeds = {}, .pins = &where});
    put_cube(*batch, 0.12, 0.01);
    test::step(*batch, Policy::kZero);
    return std::vector<std::uint8_t>(batch->images().rgb.begin(), batch->images().rgb.end());
  };
  CHECK((rgb(-1) == rgb(1)));
}

TEST_CASE("Regions cost nothing in physics and are in nobody's way", "[take_it_back]") {
  const auto batch = make_env(kId);
  const PhysicsModel& model = batch->physics_model();
  int regions = 0;
  for (std::size_t prop = 0; prop < model.props().size(); ++prop) {
    const bool is_region = model.props()[prop].name.ends_with("region");
    CHECK(model.props()[prop].tangible() != is_region);
    CHECK((model.collision().body_of_prop(static_cast<int>(prop)) < 0) == is_region);
    regions += is_region ? 1 : 0;
  }
  CHECK(regions == 3);
}

}  // namespace
