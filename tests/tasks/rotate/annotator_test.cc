// Words of RotateLenient and RotateStrict, against what episodes draw.
#include "tasks/rotate/annotator.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/tasks/annotated_episode.h"

namespace engram {
namespace {

using test::AnnotatedEpisode, test::play_annotated, test::row, test::Texts;

TEST_CASE("Words of Rotate: the angle of the instruction, and the first yaw", "[labels][rotate]") {
  for (const char* id : {"RotateLenientPos-VLA-v0", "RotateStrictPosNeg-VLA-v0"}) {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      INFO(id << ", seed " << seed);
      const AnnotatedEpisode episode = play_annotated(id, seed);
      REQUIRE(episode.success);
      const double yaw = *row<double>(test::memory_of(*episode.batch).find("initial_yaw"), 0);
      const long degrees = std::lround(yaw * 180 / std::numbers::pi);
      CHECK(episode.memories() ==
            Texts{"the peg pointed first at a yaw of " + std::to_string(degrees) + " degrees"});
      // "Rotate the peg by 63 degrees to ..."
      const std::string instruction = Queries(*episode.batch).instruction(0);
      const std::string turn = "r" + instruction.substr(1, instruction.find(" to ") - 1);
      CHECK(episode.frames.front().plan == Texts{"move to the peg", turn, "let the peg rest"});
      CHECK(episode.end.words() == "let the peg rest");
      for (const test::AnnotatedFrame& frame : episode.frames) CHECK(frame.object == 0);
    }
  }
}

TEST_CASE("Words of Rotate: the peg rests within the threshold", "[labels][rotate]") {
  const auto batch = test::make_running("RotateLenientPos-VLA-v0",
                                        {.seed = 5, .threads = 1, .auto_reset = AutoReset::kOff});
  int rests = 0;
  while ((batch->outputs().terminated[0] | batch->outputs().truncated[0]) == 0) {
    const double error = static_cast<double>(*row<float>(batch->output("y_angle_error"), 0));
    const bool episode = test::annotate(*batch).subtask == 2;
    if (std::abs(std::abs(error) - 0.1) > 1e-5) CHECK(episode == (std::abs(error) < 0.1));
    rests += episode ? 1 : 0;
    test::step(*batch, Policy::kOracle);
  }
  CHECK(rests > 0);
}

}  // namespace
}  // namespace engram
