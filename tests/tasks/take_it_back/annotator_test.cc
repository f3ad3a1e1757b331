// Words of TakeItBack, against what episodes draw.
#include "tasks/take_it_back/annotator.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "tests/tasks/annotated_episode.h"

namespace engram {
namespace {

using test::AnnotatedEpisode, test::play_annotated, test::row, test::Texts;

TEST_CASE("Words of TakeItBack: where the cube was first", "[labels][take_it_back]") {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    const AnnotatedEpisode episode = play_annotated("TakeItBack-VLA-v0", seed);
    REQUIRE(episode.success);
    const double* initial = row<double>(test::memory_of(*episode.batch).find("initial"), 0);
    CHECK(episode.memories() ==
          Texts{"the cube was first at x = " + std::to_string(std::lround(100 * initial[0])) +
                " cm, y = " + std::to_string(std::lround(100 * initial[1])) + " cm"});
    CHECK(episode.subtasks() == Texts{"move to the cube", "bring the cube onto the red target",
                                      "bring the cube back to where it was first"});
    for (const test::AnnotatedFrame& frame : episode.frames) CHECK(frame.object == 0);
  }
}

TEST_CASE("Words of TakeItBack: the way back begins on the target", "[labels][take_it_back]") {
  const auto batch = test::make_running("TakeItBack-VLA-v0",
                                        {.seed = 2, .threads = 1, .auto_reset = AutoReset::kOff});
  int back = 0;
  while ((batch->outputs().terminated[0] | batch->outputs().truncated[0] |
          batch->outputs().success[0]) == 0) {
    const bool reached = *row<std::uint8_t>(batch->output("goal_reached_status"), 0) != 0;
    CHECK((test::annotate(*batch).subtask == 2) == reached);
    back += reached ? 1 : 0;
    test::step(*batch, Policy::kOracle);
  }
  CHECK(back > 0);
}

}  // namespace
}  // namespace engram
