// Tests of the ball at the goal of ShellGamePush and ShellGamePick, and in its mug on the way.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "core/batch/scene_renderer.h"
#include "mjcf/mug.h"
#include "protocol/make/make.h"
#include "tests/differing_pixels.h"
#include "tests/env_helpers.h"
#include "tests/tasks/first_answer.h"
#include "tests/tasks/shell_game/ids.h"

namespace engram {
namespace {

using Eigen::Quaterniond, Eigen::Vector3d, test::first_answer, test::FirstAnswer, test::row;
using namespace test::shell_game;

constexpr double kRest = mjcf::kMugRestingHeight;
constexpr int kBall = 3;
constexpr int kGoal = 4;

Vector3d pos(const Batch& batch, int prop, int index = 0) {
  return Eigen::Map<Vector3d>(batch.state().prop_pos_of(index, prop));
}

MakeOptions at_cup(int cup, ConstantTable constants = {}) {
  MakeOptions options{{.reward_mode = RewardMode::kDense,
                       .auto_reset = AutoReset::kOff,
                       .terminate_on_success = false,
                       .pins = {{"cue_steps", {1}},
                                {"base", {0, 0}},
                                {"cup_with_ball_number", {static_cast<double>(cup)}}}},
                      std::move(constants)};
  return options;
}

// One environment in which the robot may act, and nothing moves but what a test moves.
struct Still {
  std::unique_ptr<Batch> batch;
  Vector3d home;  // of mug 1

  Still(const char* id, ConstantTable constants = {}) {
    MakeOptions options = at_cup(1, std::move(constants));
    options.substeps = 0;
    batch = make(id, options);
    batch->reset();
    test::step(*batch, Policy::kZero);
    home = pos(*batch, 1);
  }

  // After a step with a mug so far from where it stood.
  bool succeeds(const Vector3d& moved, int mug = 1, double speed = 0) const {
    const Vector3d there = home + Vector3d(0, 0.2 * (mug - 1), 0) + moved;
    std::copy_n(there.data(), 3, batch->state().prop_pos_of(0, mug));
    batch->state().qvel.row(0)[0] = speed;
    test::step(*batch, Policy::kZero);
    return batch->outputs().success[0] != 0;
  }
  void turn(const Quaterniond& by) const {
    double* q = batch->state().prop_quat_of(0, 1);
    const Quaterniond turned = by * Quaterniond(q[0], q[1], q[2], q[3]);
    q[0] = turned.w();
    q[1] = turned.x();
    q[2] = turned.y();
    q[3] = turned.z();
  }
  Vector3d ball() const { return pos(*batch, kBall); }
  bool covered() const { return (batch->state().covered[0] >> kBall & 1U) != 0; }
  double term(const char* name) const {
    test::step(*batch, Policy::kZero);  // reward_dict lags a step behind
    const std::vector<Field>& terms = batch->info().reward_terms;
    const auto found = std::ranges::find(terms, name, &Field::name);
    REQUIRE(found != terms.end());
    return static_cast<double>(row<float>(batch->output("reward_dict"), 0)[found - terms.begin()]);
  }
};

// "The ball center must finish inside the goal region": goal 0.1 m ahead of the ball and 0.03 m
// above it, GOAL_THRESH 0.06 m about it.
TEST_CASE("The ball's centre has to finish inside Push's goal region", "[shell][rules]") {
  const double half = std::sqrt(0.06 * 0.06 - 0.03 * 0.03);  // of the region at the ball's height
  const Still push(kPush);
  CHECK_FALSE(push.succeeds({0, 0, 0}));
  CHECK_FALSE(push.succeeds({0.0042, 0, 0}));  // the mug is within 1.6 GOAL_THRESH
  CHECK_FALSE(push.succeeds({0.1 - half - 1e-6, 0, 0}));
  CHECK(*row<std::uint8_t>(push.batch->output("is_obj_placed"), 0) == 0);
  CHECK(push.succeeds({0.1 - half + 1e-6, 0, 0}));
  CHECK((push.ball() - Vector3d(0.1 - half + 1e-6, 0, 0.02)).norm() < 1e-12);
  CHECK(push.batch->outputs().reward[0] == 4);
  CHECK(push.succeeds({0.1, half - 1e-6, 0}));
  CHECK_FALSE(push.succeeds({0.1, half + 1e-6, 0}));
  CHECK(push.succeeds({0.1 + half - 1e-6, 0, 0}));
  CHECK_FALSE(push.succeeds({0.1 + half + 1e-6, 0, 0}));
  CHECK_FALSE(push.succeeds({0.1, 0, 0}, 1, 0.3001));
  // Another cup takes no ball along.
  CHECK_FALSE(push.succeeds({0, 0, 0}));
  CHECK_FALSE(push.succeeds({0.1, 0, 0}, 0));
}

// "The ball must be placed inside the goal region above the correct cup site": goal 0.125 m above
// where the ball lay, GOAL_THRESH 0.05 m about it.
TEST_CASE("The ball has to be lifted in its cup into Pick's goal region", "[shell][rules]") {
  const Still pick(kPick);
  CHECK_FALSE(pick.succeeds({0, 0, 0}));
  CHECK_FALSE(pick.succeeds({0, 0, 0.05}));  // the mug is within 1.6 GOAL_THRESH
  CHECK_FALSE(pick.succeeds({0, 0, 0.075 - 1e-6}));
  CHECK(pick.succeeds({0, 0, 0.075 + 1e-6}));
  CHECK((pick.ball() - Vector3d(0, 0, 0.095 + 1e-6)).norm() < 1e-12);
  CHECK(pick.batch->outputs().reward[0] == 75);
  CHECK(pick.succeeds({0.03, -0.03, 0.125}));
  CHECK_FALSE(pick.succeeds({0.04, -0.04, 0.125}));  // not above its site
  CHECK_FALSE(pick.succeeds({0, 0, 0.1751}));
  CHECK_FALSE(pick.succeeds({0, 0, 0.1}, 1, 0.2001));
  CHECK_FALSE(pick.succeeds({0, 0, 0}));
  CHECK_FALSE(pick.succeeds({0, 0, 0.1}, 2));
}

TEST_CASE("Infos and rewards measure the ball's way to the goal", "[shell][rules]") {
  for (const char* id : {kPush, kPick}) {
    INFO(id);
    const Still game(id);
    const Vector3d goal = pos(*game.batch, kGoal);
    for (const Vector3d& moved : {Vector3d(0, 0, 0), Vector3d(0.03, 0.01, 0)}) {
      CHECK_FALSE(game.succeeds(moved));
      const float* offset = row<float>(game.batch->output("obj_to_goal_pos"), 0);
      const Vector3d way = goal - (Vector3d(0, 0, 0.02) + moved);
      for (int i = 0; i < 3; ++i) CHECK(offset[i] == Approx(way[i]).margin(1e-6));
      CHECK(game.term("obj_to_goal_dist") == Approx(way.norm()).margin(1e-6));
      CHECK(game.term("place_reward") == Approx(1 - std::tanh(5 * way.norm())).margin(1e-6));
    }
  }
}

TEST_CASE("GOAL_THRESH is anything at which the ball can come to the goal", "[shell][rules]") {
  for (const double thresh : {0.0625, 0.09, 0.12, 0.2, 0.3}) {
    INFO(thresh);
    const Still push(kPush, {{"GOAL_THRESH", thresh}});
    const double half = std::sqrt(thresh * thresh - 0.03 * 0.03);
    // Where the region reaches to the ball's slot, a push is needed all the same.
    const double least = std::max(0.1 - half, 0.01);
    CHECK_FALSE(push.succeeds({0, 0, 0}));
    CHECK_FALSE(push.succeeds({least - 1e-6, 0, 0}));
    CHECK(push.succeeds({least + 1e-6, 0, 0}));
    CHECK_FALSE(push.succeeds({-0.02, 0, 0}));
    CHECK_FALSE(push.succeeds({0.1 + half + 1e-6, 0, 0}));

    const Still pick(kPick, {{"GOAL_THRESH", thresh}});
    const double lift = std::max(0.125 - thresh, 0.01);
    CHECK_FALSE(pick.succeeds({0, 0, 0}));
    CHECK_FALSE(pick.succeeds({0, 0, lift - 1e-6}));
    CHECK(pick.succeeds({0, 0, lift + 1e-6}));
  }
  MakeOptions options = at_cup(1, {{"GOAL_THRESH", 0.03}});
  CHECK_THROWS_WITH(make(kPush, options),
                    "balls never are in the goal region: GOAL_THRESH = 30 mm, "
                    "and its centre is 30 mm above a ball's");
  for (const auto& [id, thresh] : {std::pair(kPush, 0.0625), {kPick, 0.058}}) {
    options = at_cup(1, {{"GOAL_THRESH", thresh}});
    CHECK_NOTHROW(make(id, options));
    options.rules = Rules::kOriginal;
    CHECK_THROWS_WITH(make(id, options), Catch::Contains("in the goal region from the start"));
    options.task_options = {{"mug_at_goal", 0}};
    CHECK_NOTHROW(make(id, options));
  }
  options = at_cup(1, {{"GOAL_THRESH", 0.02}});
  options.rules = Rules::kOriginal;
  CHECK_NOTHROW(make(kPush, options));
}

TEST_CASE("A ball stays inside its cup, wherever that goes", "[shell][rules]") {
  const Still pick(kPick);
  CHECK(pick.covered());
  pick.succeeds({0.01, 0.02, 0.06});
  CHECK((pick.ball() - Vector3d(0.01, 0.02, 0.08)).norm() < 1e-12);
  CHECK(pick.covered());
  // It turns with the cup, about the cup's origin.
  const auto tilt = [](double angle) {
    return Quaterniond(Eigen::AngleAxisd(angle, Vector3d::UnitY()));
  };
  pick.turn(tilt(0.3));
  pick.succeeds({0, 0, 0.06});
  const auto inside = [&pick]() -> Vector3d { return pick.ball() - pos(*pick.batch, 1); };
  CHECK((inside() - tilt(0.3) * Vector3d(0, 0, 0.02 - kRest)).norm() < 1e-9);
  CHECK(pick.covered());
  // In a cup that lies it rolls onto the wall, in one with its mouth up onto the foot.
  pick.turn(tilt(1.57 - 0.3));
  pick.succeeds({0, 0, 0.1});
  CHECK_FALSE(pick.covered());
  CHECK(inside().z() == Approx(0.02 - mjcf::kMugHides).margin(1e-3));
  CHECK(inside().head<2>().norm() == Approx(kRest - 0.02).margin(1e-3));
  pick.turn(tilt(1.57));
  pick.succeeds({0, 0, 0.1});
  CHECK_FALSE(pick.covered());
  CHECK(inside().z() == Approx(0.025 - kRest).margin(1e-3));
  // Never below the table.
  pick.succeeds({0, 0, -0.02});
  CHECK(pick.ball().z() >= 0.02);
}

TEST_CASE("A cup that is moved so far that the ball may show is an answer", "[shell][answer]") {
  for (const char* id : {kPush, kPick}) {
    INFO(id);
    const Still game(id);
    game.succeeds({0, 0, 0.0039}, 0);
    CHECK(first_answer(*game.batch) == FirstAnswer{});
    CHECK(game.covered());
    game.succeeds({0, 0, 0.0041}, 0);
    CHECK(first_answer(*game.batch) == FirstAnswer{true, 0, false});
  }
}

// --- images ---

int red_pixels(SceneRenderer& renderer, int index, const char* camera) {
  constexpr int kSize = 128;
  std::vector<std::uint8_t> rgb(std::size_t{kSize} * kSize * 3);
  renderer.render(index, camera, kSize, kSize, rgb);
  int count = 0;
  for (std::size_t i = 0; i < rgb.size(); i += 3) {
    count += rgb[i] > 150 && rgb[i + 1] < 40 && rgb[i + 2] < 40 ? 1 : 0;
  }
  return count;
}

TEST_CASE("Images show the ball in the cue, and not in the cup that is lifted", "[render][shell]") {
  MakeOptions options = at_cup(1);
  options.num_envs = 8;
  options.pins.pop_back();  // any cup
  const auto batch = make(kPick, options);
  batch->reset();
  SceneRenderer renderer(*batch);
  for (int i = 0; i < options.num_envs; ++i) CHECK(red_pixels(renderer, i, "base_camera") > 8);
  int lifted = 0;
  for (int t = 1; t <= 30; ++t) {
    test::step(*batch, Policy::kOracle);
    for (int i = 0; i < options.num_envs; ++i) {
      INFO("environment " << i << ", step " << t);
      for (const char* camera : {"base_camera", "hand_camera", "render_camera"}) {
        CHECK(red_pixels(renderer, i, camera) == 0);
      }
      lifted += pos(*batch, kBall, i).z() > 0.095 ? 1 : 0;
    }
  }
  CHECK(lifted > 10);
  // A cup that lies shows it.
  const Still tipped(kPick);
  tipped.turn(Quaterniond(Eigen::AngleAxisd(-1.5, Vector3d::UnitY())));
  tipped.succeeds({0.1, 0.05, 0.01});
  SceneRenderer of_tipped(*tipped.batch);
  CHECK(red_pixels(of_tipped, 0, "base_camera") > 4);
}

// Images of two episodes that differ in where the ball is, while the middle cup is lifted.
int pixels_that_tell(Rules rules) {
  MakeOptions options = at_cup(1, {{"GOAL_THRESH", 0.02}, {"max_episode_steps", 40}});
  options.rules = rules;
  const auto one = make(kPick, options);
  options.pins.back().values = {0};
  const auto other = make(kPick, options);
  one->reset();
  other->reset();
  test::ImagePair images(*one, *other);
  int telling = 0;
  double lifted = 0;
  for (int t = 1; t <= 40; ++t) {
    const std::vector<float> actions = test::act(*one, Policy::kSweep);
    one->step(actions);
    other->step(actions);
    for (const char* camera : {"base_camera", "hand_camera"}) {
      telling += images.differing_pixels(camera);
    }
    lifted = std::max(lifted, pos(*other, 1).z() - kRest);
  }
  CHECK(lifted > 0.05);
  return telling;
}

TEST_CASE("A cup that is lifted does not show whether the ball is in it", "[render][shell][leak]") {
  CHECK(pixels_that_tell(Rules::kReference) == 0);
  CHECK(pixels_that_tell(Rules::kOriginal) > 0);
}

// --- by the oracle ---

double success_rate(const char* id, const MakeOptions& options, Policy policy) {
  const auto batch = make(id, options);
  batch->reset();
  for (int t = 0; t < batch->info().horizon; ++t) test::step(*batch, policy);
  int successes = 0;
  for (int i = 0; i < options.num_envs; ++i) {
    successes += *row<std::uint8_t>(batch->output("success_once"), i);
  }
  return static_cast<double>(successes) / options.num_envs;
}

TEST_CASE("The oracle brings the ball into regions of any size", "[shell][oracle]") {
  struct Size {
    const char* id;
    double thresh;
  };
  for (const auto& [id, thresh] : {Size{kPush, 0.035},
                                   {kPush, 0.06},
                                   {kPush, 0.1},
                                   {kPush, 0.3},
                                   {kPick, 0.03},
                                   {kPick, 0.05},
                                   {kPick, 0.1},
                                   {kPick, 0.3}}) {
    INFO(id << " " << thresh);
    const MakeOptions options{
        {.num_envs = 40, .seed = 4242424242, .threads = 2, .auto_reset = AutoReset::kOff},
        {{"GOAL_THRESH", thresh}}};
    CHECK(success_rate(id, options, Policy::kOracle) >= 0.95);
    CHECK(success_rate(id, options, Policy::kZero) == 0);
    CHECK(std::abs(success_rate(id, options, Policy::kBlind) - 1.0 / 3) <= 0.2);
  }
}

}  // namespace
}  // namespace engram
