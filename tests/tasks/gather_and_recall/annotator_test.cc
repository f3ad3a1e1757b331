// Words of GatherAndRecall, against what episodes draw.
#include "tasks/gather_and_recall/annotator.h"

#include <catch2/catch.hpp>
#include <set>
#include <string>
#include <vector>

#include "tests/tasks/told_episode.h"

namespace engram {
namespace {

using test::play_told;
using test::row;
using test::ToldEpisode;
using test::ToldFrame;

using Texts = std::vector<std::string>;

TEST_CASE("Words of GatherAndRecall: the flash, once it has come", "[labels][gather_and_recall]") {
  const char* const colors[] = {"red", "green", "blue"};
  for (int color = 0; color < 3; ++color) {
    const std::string name = colors[color];
    INFO(name);
    const ToldEpisode told =
        play_told("GatherAndRecall3-VLA-v0", 6, {{"flash_color", {1.0 * color}}});
    REQUIRE(told.success);
    CHECK(told.memories() == Texts{"", "the lamp flashed " + name});
    CHECK(told.subtasks() ==
          Texts{"move a cube onto the disc, cube 1 of 3", "move a cube onto the disc, cube 2 of 3",
                "move a cube onto the disc, cube 3 of 3", "press the " + name + " button"});
    for (const ToldFrame& frame : told.frames) {
      const bool flashed = !frame.memory.empty();
      CHECK(frame.plan.back() == (flashed ? "press the " + name + " button"
                                          : "press the button with the flash's color"));
    }
    const auto props = told.env->physics_model().props();
    CHECK(props[static_cast<std::size_t>(told.frames.front().object)].name.starts_with(
        "gather_cube"));
    CHECK(props[static_cast<std::size_t>(told.frames.back().object)].name ==
          "button_" + name + "_cap");
  }
}

// Against the columns, frame by frame.
TEST_CASE("Words of GatherAndRecall: flash and cubes as they are", "[labels][gather_and_recall]") {
  BatchOptions options;
  options.seed = 9;
  options.threads = 1;
  options.auto_reset = AutoReset::kOff;
  const auto env = test::make_env("GatherAndRecall3-VLA-v0", options);
  env->reset();
  const auto flag = [&](const char* name) { return *row<std::uint8_t>(env->output(name), 0) != 0; };
  std::set<int> carried;
  CHECK(test::tell(*env).object == 0);
  while ((env->terminated()[0] | env->truncated()[0] | env->success()[0]) == 0) {
    const ToldFrame frame = test::tell(*env);
    CHECK(frame.memory.empty() == !flag("flash_triggered"));
    CHECK((frame.subtask == 3) == flag("all_on_disc"));
    const auto* on_disc = row<std::uint8_t>(env->memory().find("cubes_on_disc"), 0);
    for (int cube = 0; cube < 3; ++cube) {
      if (on_disc[cube] != 0 || !is_grasping(env->state(), 0, cube)) continue;
      CHECK(frame.object == cube);
      carried.insert(cube);
    }
    test::step(*env, Policy::kOracle);
  }
  CHECK(carried == std::set<int>{0, 1, 2});
}

}  // namespace
}  // namespace engram
