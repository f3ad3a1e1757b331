// Words of Intercept and InterceptGrab.
#include "tasks/intercept/annotator.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/tasks/annotated_episode.h"

namespace engram {
namespace {

using test::AnnotatedEpisode, test::AnnotatedFrame, test::play_annotated, test::Texts;

TEST_CASE("Words of Intercept: nothing to remember, one thing after the other",
          "[labels][intercept]") {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const AnnotatedEpisode deflect = play_annotated("InterceptSlow-VLA-v0", seed);
    REQUIRE(deflect.success);
    CHECK(deflect.subtasks() ==
          Texts{"move to the path of the ball", "bring the ball to the target"});
    const AnnotatedEpisode grab = play_annotated("InterceptGrabSlow-VLA-v0", seed);
    for (const AnnotatedEpisode* episode : {&deflect, &grab}) {
      CHECK(episode->memories() == Texts{""});
      for (const AnnotatedFrame& frame : episode->frames) CHECK(frame.object == 0);
    }
    if (!grab.success) continue;
    CHECK(grab.subtasks().front() == "move to the path of the ball");
    CHECK(grab.subtasks().size() >= 2);
  }
}

// A ball in the hand is held, whatever was episode before.
TEST_CASE("Words of InterceptGrab: a grasped ball is to be held still", "[labels][intercept]") {
  int held = 0;
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U}) {
    const auto batch = test::make_running(
        "InterceptGrabSlow-VLA-v0", {.seed = seed, .threads = 1, .auto_reset = AutoReset::kOff});
    while ((batch->outputs().terminated[0] | batch->outputs().truncated[0]) == 0) {
      const bool grasped = *test::row<std::uint8_t>(batch->output("is_ball_grasped"), 0) != 0;
      const AnnotatedFrame frame = test::annotate(*batch);
      CHECK((frame.words() == "hold the ball still") == grasped);
      held += grasped ? 1 : 0;
      test::step(*batch, Policy::kOracle);
    }
  }
  CHECK(held > 0);
}

}  // namespace
}  // namespace engram
