// Words of BlinkCountButtonPress, against what episodes draw.
#include "tasks/blink_count/annotator.h"

#include <catch2/catch.hpp>
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

TEST_CASE("Words of BlinkCount: blinks as they come, then presses", "[labels][blink_count]") {
  for (int blinks = 1; blinks <= 3; ++blinks) {
    INFO(blinks << " blinks");
    const ToldEpisode told =
        play_told("BlinkCountButtonPressEasy-VLA-v0", 3, {{"target_blinks", {1.0 * blinks}}});
    REQUIRE(told.success);
    const int* starts = row<std::int32_t>(told.env->memory().find("blink_start"), 0);
    const int acts = *row<std::int32_t>(told.env->memory().find("cue_steps"), 0);
    for (int t = 0; t < static_cast<int>(told.frames.size()); ++t) {
      INFO("frame " << t);
      const ToldFrame& frame = told.frames[static_cast<std::size_t>(t)];
      int seen = 0;
      while (seen < blinks && t >= starts[seen]) ++seen;
      const std::string number = std::to_string(seen) + (seen == 1 ? " time" : " times");
      const bool acting = t >= acts;
      if (seen == 0) CHECK(frame.memory.empty());
      if (seen > 0) {
        CHECK(frame.memory ==
              (acting ? "the lamp blinked " : "the lamp has blinked so far ") + number);
      }
      CHECK((frame.subtask == 0) == !acting);
      CHECK(frame.plan.size() == (acting ? static_cast<std::size_t>(blinks) + 2 : 3));
    }
    Texts expected = {"count how often the lamp blinks"};
    for (int press = 1; press <= blinks; ++press) {
      expected.push_back("press the red button, press " + std::to_string(press) + " of " +
                         std::to_string(blinks));
    }
    expected.emplace_back("press the black button");
    CHECK(told.subtasks() == expected);
    const auto props = told.env->physics_model().props();
    const auto object = [&](const ToldFrame& frame) {
      return props[static_cast<std::size_t>(frame.object)].name;
    };
    CHECK(object(told.frames.front()) == "blink_lamp_bulb");
    CHECK(object(told.frames[static_cast<std::size_t>(acts)]) == "button_cap");
    CHECK(object(told.frames.back()) == "confirm_button_cap");
  }
}

}  // namespace
}  // namespace engram
