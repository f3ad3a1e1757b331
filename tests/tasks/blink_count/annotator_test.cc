// Words of BlinkCountButtonPress, against what episodes draw.
#include "tasks/blink_count/annotator.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/tasks/annotated_episode.h"

namespace engram {
namespace {

using test::AnnotatedEpisode, test::AnnotatedFrame, test::play_annotated, test::row, test::Texts;

TEST_CASE("Words of BlinkCount: blinks as they come, then presses", "[labels][blink_count]") {
  for (int blinks = 1; blinks <= 3; ++blinks) {
    INFO(blinks << " blinks");
    const AnnotatedEpisode episode =
        play_annotated("BlinkCountButtonPressEasy-VLA-v0", 3, {{"target_blinks", {1.0 * blinks}}});
    REQUIRE(episode.success);
    const int* starts = row<std::int32_t>(test::memory_of(*episode.batch).find("blink_start"), 0);
    const int acts = *row<std::int32_t>(test::memory_of(*episode.batch).find("cue_steps"), 0);
    for (int t = 0; t < static_cast<int>(episode.frames.size()); ++t) {
      INFO("frame " << t);
      const AnnotatedFrame& frame = episode.frames[static_cast<std::size_t>(t)];
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
    CHECK(episode.subtasks() == expected);
    const auto props = episode.batch->physics_model().props();
    const auto object = [&](const AnnotatedFrame& frame) {
      return props[static_cast<std::size_t>(frame.object)].name;
    };
    CHECK(object(episode.frames.front()) == "blink_lamp_bulb");
    CHECK(object(episode.frames[static_cast<std::size_t>(acts)]) == "button_cap");
    CHECK(object(episode.frames.back()) == "confirm_button_cap");
  }
}

}  // namespace
}  // namespace engram
