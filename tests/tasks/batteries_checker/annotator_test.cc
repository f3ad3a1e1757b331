// Words of BatteriesCheckerEasy and BatteriesCheckerHard, against what episodes draw.
#include "tasks/batteries_checker/annotator.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/tasks/annotated_episode.h"

namespace engram {
namespace {

using test::AnnotatedEpisode, test::AnnotatedFrame, test::play_annotated, test::Texts;

TEST_CASE("Words of BatteriesChecker: results as the lamp shows them",
          "[labels][batteries_checker]") {
  for (const char* id : {"BatteriesCheckerEasy-3-VLA-v0", "BatteriesCheckerHard-3-VLA-v0"}) {
    INFO(id);
    const bool hard = std::string(id).find("Hard") != std::string::npos;
    const AnnotatedEpisode episode = play_annotated(id, 2, {{"working", {1}}});
    REQUIRE(episode.success);
    CHECK(episode.memories() ==
          Texts{"", "battery 1 does not work", "battery 1 does not work and battery 2 works"});
    Texts expected;
    for (const char* battery : {"battery 1", "battery 2", "battery 3"}) {
      expected.push_back(std::string("put ") + battery + " into the socket and look at the lamp");
      if (hard) expected.push_back(std::string("put ") + battery + " back into its slot");
      expected.emplace_back("press the button");
    }
    CHECK(episode.frames.front().plan == expected);
    // The second battery is the one that works: the third one is left.
    const int per_battery = hard ? 3 : 2;
    CHECK(episode.frames.back().subtask == 2 * per_battery - 1);
    CHECK(episode.frames.back().done == 2 * per_battery - 1);
    int done = 0;
    for (const AnnotatedFrame& frame : episode.frames) {
      CHECK(frame.done >= done);
      done = frame.done;
    }
    const auto props = episode.batch->physics_model().props();
    CHECK(props[static_cast<std::size_t>(episode.frames.back().object)].name ==
          "battery_button_cap");
  }
}

}  // namespace
}  // namespace engram
