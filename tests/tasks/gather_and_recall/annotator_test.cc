// Words of GatherAndRecall, against what episodes draw.
#include "tasks/gather_and_recall/annotator.h"

#include <catch2/catch.hpp>
#include <set>
#include <string>
#include <vector>

#include "tests/tasks/annotated_episode.h"

namespace engram {
namespace {

using test::AnnotatedEpisode, test::AnnotatedFrame, test::play_annotated, test::row, test::Texts;

TEST_CASE("Words of GatherAndRecall: the flash, once it has come", "[labels][gather_and_recall]") {
  const char* const colors[] = {"red", "green", "blue"};
  for (int color = 0; color < 3; ++color) {
    const std::string name = colors[color];
    INFO(name);
    const AnnotatedEpisode episode =
        play_annotated("GatherAndRecall3-VLA-v0", 6, {{"flash_color", {1.0 * color}}});
    REQUIRE(episode.success);
    CHECK(episode.memories() == Texts{"", "the lamp flashed " + name});
    CHECK(episode.subtasks() ==
          Texts{"move a cube onto the disc, cube 1 of 3", "move a cube onto the disc, cube 2 of 3",
                "move a cube onto the disc, cube 3 of 3", "press the " + name + " button"});
    for (const AnnotatedFrame& frame : episode.frames) {
      const bool flashed = !frame.memory.empty();
      CHECK(frame.plan.back() == (flashed ? "press the " + name + " button"
                                          : "press the button with the flash's color"));
    }
    const auto props = episode.batch->physics_model().props();
    CHECK(props[static_cast<std::size_t>(episode.frames.front().object)].name.starts_with(
        "gather_cube"));
    CHECK(props[static_cast<std::size_t>(episode.frames.back().object)].name ==
          "button_" + name + "_cap");
  }
}

// Against the columns, frame by frame.
TEST_CASE("Words of GatherAndRecall: flash and cubes as they are", "[labels][gather_and_recall]") {
  const auto batch = test::make_running("GatherAndRecall3-VLA-v0",
                                        {.seed = 9, .threads = 1, .auto_reset = AutoReset::kOff});
  const auto flag = [&](const char* name) {
    return *row<std::uint8_t>(batch->output(name), 0) != 0;
  };
  std::set<int> carried;
  CHECK(test::annotate(*batch).object == 0);
  while ((batch->outputs().terminated[0] | batch->outputs().truncated[0] |
          batch->outputs().success[0]) == 0) {
    const AnnotatedFrame frame = test::annotate(*batch);
    CHECK(frame.memory.empty() == !flag("flash_triggered"));
    CHECK((frame.subtask == 3) == flag("all_on_disc"));
    const auto* on_disc = row<std::uint8_t>(test::memory_of(*batch).find("cubes_on_disc"), 0);
    for (int cube = 0; cube < 3; ++cube) {
      if (on_disc[cube] != 0 || !is_grasping(batch->state(), 0, cube)) continue;
      CHECK(frame.object == cube);
      carried.insert(cube);
    }
    test::step(*batch, Policy::kOracle);
  }
  CHECK(carried == std::set<int>{0, 1, 2});
}

}  // namespace
}  // namespace engram
