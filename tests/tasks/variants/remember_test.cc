// What follows from the constants of the families that recall objects.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <string>

#include "core/batch/queries.h"
#include "tests/env_helpers.h"
#include "tests/tasks/leak_check.h"

namespace engram {
namespace {

using test::row;

std::unique_ptr<Batch> make(const std::string& id, const ConstantTable& constants,
                            int num_envs = 1) {
  return test::make_running(
      id, MakeOptions{{.num_envs = num_envs, .threads = 1, .reward_mode = RewardMode::kDense},
                      constants});
}

const PropModel& first_prop(const Batch& batch) { return batch.physics_model().props().front(); }

const RandomVariable& draw(const Batch& batch, const std::string& name) {
  for (const RandomVariable& one : Queries(batch).random_variables()) {
    if (one.name == name) return one;
  }
  FAIL("no draw " << name);
  throw;
}

TEST_CASE("COLORS is the number of cubes and of answers", "[variants]") {
  for (const char* id : {"RememberColor9-VLA-v0", "FindImposterColor9-VLA-v0"}) {
    for (const int colors : {2, 6}) {
      const auto batch = make(id, {{"COLORS", colors}});
      CHECK(batch->info().candidates == colors);
      CHECK(batch->info().chance() == Approx(1.0 / colors));
      CHECK(batch->physics_model().props().size() == static_cast<std::size_t>(colors));
      CHECK(draw(*batch, batch->info().hidden_variable).high == colors - 1);
      CHECK(draw(*batch, "positions").width == 2 * colors);
      // oracle_info and a pose per object
      CHECK(batch->state_dim() == 25 + 1 + 3 * colors);
    }
  }
}

TEST_CASE("Objects of other sizes weigh, stand and are spaced accordingly", "[variants]") {
  struct Case {
    const char* id;
    const char* constant;
  };
  for (const Case& one : {Case{"RememberColor5-VLA-v0", "CUBE_HALFSIZE"},
                          Case{"RememberShape5-VLA-v0", "SHAPE_SCALE"},
                          Case{"FindImposterShapeAndColor3x2-VLA-v0", "SHAPE_SCALE"}}) {
    const auto plain = make(one.id, {});
    const auto large = make(one.id, {{one.constant, 0.03}});
    CHECK(first_prop(*plain).mass == Approx(1000 * std::pow(0.04, 3)));
    CHECK(first_prop(*large).mass == Approx(1000 * std::pow(0.06, 3)));
    CHECK(first_prop(*large).bounding_radius == Approx(1.5 * first_prop(*plain).bounding_radius));
  }
  // Jitter grows with the size: the same draw, 1.5 times as far.
  const auto at = [](const Batch& batch) {
    return row<double>(test::memory_of(batch).find("positions"), 0);
  };
  const auto plain = make("RememberColor5-VLA-v0", {{"CUBE_HALFSIZE", 0.02}});
  const auto small = make("RememberColor5-VLA-v0", {{"CUBE_HALFSIZE", 0.01}});
  CHECK(at(*plain)[2] == 0.02);
  CHECK(at(*small)[2] == 0.01);
  double moved = 0;
  for (int i = 0; i < 15; ++i) moved += std::abs(at(*plain)[i] - at(*small)[i]);
  CHECK(moved > 0.02);
}

TEST_CASE("Cue and delay last as long as their constants say", "[variants]") {
  const ConstantTable constants = {
      {"CUE_PHASE_STEPS", 7}, {"EMPTY_PHASE_STEPS", ConstantList{9, 9}}, {"max_episode_steps", 60}};
  for (const char* id : {"RememberColor3-VLA-v0", "RememberShape3-Long-VLA-v0",
                         "FindImposterShapeAndColor3x3-VLA-v0"}) {
    const auto batch = make(id, constants);
    CHECK(Queries(*batch).cue_end(0) == 7);
    const auto shown = [&] {
      int count = 0;
      for (int prop = 0; prop < batch->info().candidates; ++prop) {
        count += batch->state().status_of(0, prop) != PropStatus::kHidden ? 1 : 0;
      }
      return count;
    };
    const std::vector<float> rest = test::zeros(*batch);
    int over = 0;
    for (int elapsed = 0; elapsed < 60; ++elapsed) {
      INFO(id << ", " << elapsed);
      if (elapsed > 0) batch->step(rest);
      if (elapsed < 7) CHECK((shown() > 0 && shown() < batch->info().candidates));
      if (elapsed >= 7 && elapsed < 16) CHECK(shown() == 0);
      if (elapsed >= 16) CHECK(shown() == batch->info().candidates);
      over += batch->outputs().truncated[0];
    }
    CHECK(over == 0);
    batch->step(rest);
    CHECK(batch->outputs().truncated[0] == 1);
  }
}

TEST_CASE("GOAL_THRESH decides what is reached", "[variants]") {
  for (const double thresh : {0.02, 0.05, 0.15}) {
    const auto batch =
        make("RememberColor3-VLA-v0", {{"GOAL_THRESH", thresh}, {"max_episode_steps", 40}}, 8);
    int placed = 0;
    for (int step = 0; step < 39; ++step) {
      test::step(*batch, Policy::kOracle);
      for (int i = 0; i < 8; ++i) {
        const float* offset = row<float>(batch->output("obj_to_goal_pos"), i);
        const double distance = Eigen::Map<const Eigen::Vector3f>(offset).cast<double>().norm();
        if (std::abs(distance - thresh) < 1e-6) continue;
        const bool is_placed = *row<std::uint8_t>(batch->output("is_obj_placed"), i) != 0;
        REQUIRE(is_placed == (distance <= thresh));
        placed += is_placed ? 1 : 0;
      }
    }
    CHECK(placed > 20);
  }
}

TEST_CASE("Shapes and colours are those that are named", "[variants]") {
  const auto shapes =
      make("RememberShape3-VLA-v0", {{"SHAPE_MAPPING", ConstantList{"star", "torus", "crescent"}}});
  const auto name = [](const Batch& batch, std::size_t prop) {
    return batch.physics_model().props()[prop].name;
  };
  CHECK(name(*shapes, 0) == "star_0");
  CHECK(name(*shapes, 2) == "crescent_2");

  const auto colored =
      make("RememberShapeAndColor3x2-VLA-v0", {{"SHAPES", 4},
                                               {"BASE_SHAPES", ConstantList{"cylinder", "cross"}},
                                               {"COLOR_PALETTE", ConstantList{"teal", "yellow"}}});
  CHECK(name(*colored, 1) == "cylinder_1");
  CHECK(name(*colored, 2) == "cross_2");
  for (const auto& [key, value] : published_constants(colored->info().constants)) {
    if (key != "COLOR_PALETTE") continue;
    const auto& palette = std::get<ConstantTable>(value.value);
    REQUIRE(palette.size() == 2);
    CHECK(palette[1].second == Constant(ConstantList{1.0, 1.0, 0.0, 1.0}));
  }
}

TEST_CASE("Penalties weigh as much as their coefficients say", "[variants]") {
  const auto none = make("RememberColor3-Long-VLA-v0",
                         {{"ACTION_L2_COEF", 0}, {"ACTION_DELTA_L2_COEF", 0}, {"QVEL_L2_COEF", 0}});
  const auto heavy =
      make("RememberColor3-Long-VLA-v0",
           {{"ACTION_L2_COEF", 0.5}, {"ACTION_DELTA_L2_COEF", 0}, {"QVEL_L2_COEF", 0}});
  std::vector<float> action = test::zeros(*none);
  action[2] = -0.4F;
  none->step(action);
  heavy->step(action);
  const double difference = static_cast<double>(none->outputs().reward[0]) -
                            static_cast<double>(heavy->outputs().reward[0]);
  CHECK(difference == Approx(0.5 * std::tanh(2 * 0.4)).margin(1e-6));
}

TEST_CASE("The noise of the start pose is a constant, too", "[variants]") {
  const auto still = make("RememberColor3-VLA-v0", {{"robot_init_qpos_noise", 0}}, 2);
  const double* first = still->state().qpos.row(0);
  const double* second = still->state().qpos.row(1);
  CHECK(std::equal(first, first + kRobotJoints, second));
  const auto noisy = make("RememberColor3-VLA-v0", {}, 2);
  CHECK_FALSE(std::equal(noisy->state().qpos.row(0), noisy->state().qpos.row(0) + kRobotJoints,
                         noisy->state().qpos.row(1)));
}

TEST_CASE("COLOR_PALETTE takes any colour", "[variants]") {
  const ConstantTable palette = {{"0", ConstantList{0.9, 0.45, 0.1, 1.0}},
                                 {"1", ConstantList{0.2, 0.2, 0.25, 1.0}}};
  const auto batch = make("FindImposterShapeAndColor3x2-VLA-v0", {{"COLOR_PALETTE", palette}});
  const std::vector<ObjectDescriptor> looks =
      make_task("FindImposterShapeAndColor3x2-VLA-v0", {{"COLOR_PALETTE", palette}})
          ->object_descriptors();
  REQUIRE(looks.size() == 6);
  for (std::size_t key = 0; key < looks.size(); ++key) {
    CHECK(kObjectColorNames[static_cast<std::size_t>(looks[key].color)] ==
          (key % 2 == 1 ? "grey" : "orange"));
  }
  CHECK(batch->info().candidates == 6);
  CHECK_FALSE(batch->info().canonical);
  const auto usual = make("FindImposterShapeAndColor3x2-VLA-v0",
                          {{"COLOR_PALETTE", ConstantList{"red", ConstantList{0, 1, 0}, "blue"}}});
  CHECK(usual->info().canonical);
  CHECK(test::batch_bytes(*usual) ==
        test::batch_bytes(*make("FindImposterShapeAndColor3x2-VLA-v0", {})));
}

TEST_CASE("Colours of the user's own are seen, and reveal nothing after the cue",
          "[variants][render][leak]") {
  const ConstantTable constants = {
      {"SHAPES", 4},
      {"COLOR_PALETTE", ConstantList{ConstantList{0.9, 0.45, 0.1}, ConstantList{0.2, 0.2, 0.25}}}};
  for (const char* id :
       {"RememberShapeAndColor3x2-VLA-v0", "FindImposterShapeAndColor3x2-VLA-v0"}) {
    INFO(id);
    test::check_leaks(id, constants, 3);
    // Tokens reveal nothing either.
    const std::unique_ptr<Task> task = make_task(id, constants);
    const auto draw = *test::draw_named(task->info(), task->info().hidden_variable);
    const auto seeing = [&](bool other) {
      const MakeOptions options{{.obs_mode = ObsMode::kObjects,
                                 .reward_mode = RewardMode::kSparse,
                                 .auto_reset = AutoReset::kOff,
                                 .pins = {{draw.name, test::hidden_values(draw, other)}}},
                                constants};
      return test::make_running(id, options);
    };
    const auto one = seeing(false);
    const auto other = seeing(true);
    int shown = 0;
    test::play_unanswered(*one, *other, Policy::kZero, [&](bool shows) {
      if (shows) {
        shown +=
            std::ranges::equal(one->outputs().observation, other->outputs().observation) ? 0 : 1;
      } else {
        REQUIRE(test::leaking_outputs(*one, *other).empty());
      }
    });
    CHECK(shown > 0);
  }
}

}  // namespace
}  // namespace engram
