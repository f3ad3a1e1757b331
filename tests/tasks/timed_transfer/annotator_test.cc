// Words of TimedTransfer, against what episodes draw.
#include "tasks/timed_transfer/annotator.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/tasks/annotated_episode.h"

namespace engram {
namespace {

using test::AnnotatedEpisode, test::AnnotatedFrame, test::play_annotated;

TEST_CASE("Words of TimedTransfer: the step of the signal", "[labels][timed_transfer]") {
  for (int signal = 1; signal <= 3; ++signal) {
    INFO("signal at " << signal);
    const AnnotatedEpisode episode =
        play_annotated("TimedTransferEasy-VLA-v0", 4, {{"signal_step", {1.0 * signal}}});
    REQUIRE(episode.success);
    const tasks::TimeWindow window = tasks::time_window(signal, 100);
    const auto props = episode.batch->physics_model().props();
    for (int t = 0; t < static_cast<int>(episode.frames.size()); ++t) {
      INFO("frame " << t);
      const AnnotatedFrame& frame = episode.frames[static_cast<std::size_t>(t)];
      CHECK(frame.memory ==
            (t < signal ? "" : "the lamp turned green at step " + std::to_string(signal)));
      CHECK((frame.subtask == 0) == (t < signal));
      CHECK((frame.subtask == 3) == (t + 1 >= window.start));
      const std::string object = props[static_cast<std::size_t>(frame.object)].name;
      const char* const objects[] = {"signal_lamp_bulb", "blue_cube", "blue_cube", "red_disc"};
      CHECK(object == objects[frame.subtask]);
    }
    CHECK(episode.subtasks() ==
          std::vector<std::string>{"wait for the lamp to turn green",
                                   "count the steps and grasp the blue cube",
                                   "count the steps and hold the blue cube",
                                   "put the blue cube onto the red disc at step 100"});
  }
}

}  // namespace
}  // namespace engram
