// Words of the Remember and Find-Imposter families, against what episodes draw.
#include "tasks/remember/annotator.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/tasks/annotated_episode.h"
#include "tests/tasks/remember/recall_env.h"

namespace engram {
namespace {

using test::AnnotatedEpisode, test::AnnotatedFrame, test::memory_int, test::play_annotated,
    test::Texts;

constexpr int kWait = 1;
constexpr int kMove = 2;
constexpr int kTouch = 3;

// The first frame of each phase, by the draws.
void check_phases(const AnnotatedEpisode& episode) {
  const int cue = memory_int(*episode.batch, "cue_steps");
  const int acts = test::appearance_of(*episode.batch);
  for (int t = 0; t < static_cast<int>(episode.frames.size()); ++t) {
    const AnnotatedFrame& frame = episode.frames[static_cast<std::size_t>(t)];
    INFO("frame " << t);
    if (t < cue) CHECK(frame.subtask == 0);
    if (t >= cue && t < acts) CHECK((frame.subtask == kWait && frame.object == -1));
    if (t >= acts) CHECK((frame.subtask == kMove || frame.subtask == kTouch));
    if (t >= acts) CHECK(frame.object == memory_int(*episode.batch, "target"));
  }
  CHECK(episode.frames.back().subtask == kTouch);
}

TEST_CASE("Words of RememberColor: the cue's color", "[labels][remember]") {
  const char* const colors[] = {"red",  "green",  "blue",   "yellow", "magenta",
                                "cyan", "maroon", "orange", "teal"};
  for (int key = 0; key < 9; ++key) {
    const std::string color = colors[key];
    INFO(color);
    const AnnotatedEpisode episode =
        play_annotated("RememberColor9-VLA-v0", 10, {{"target", {1.0 * key}}});
    REQUIRE(episode.success);
    CHECK(episode.frames[0].object == key);
    CHECK(episode.memories() == Texts{"the cue was a " + color + " cube"});
    CHECK(episode.subtasks() == Texts{"remember the color of the cube", "wait",
                                      "move to the " + color + " cube",
                                      "touch the " + color + " cube"});
    check_phases(episode);
  }
}

TEST_CASE("Words of RememberShape and RememberShapeAndColor", "[labels][remember]") {
  const AnnotatedEpisode shape = play_annotated("RememberShape9-VLA-v0", 3, {{"target", {7}}});
  REQUIRE(shape.success);
  CHECK(shape.memories() == Texts{"the cue was a T shape"});
  CHECK(shape.subtasks() == Texts{"remember the shape of the object", "wait", "move to the T shape",
                                  "touch the T shape"});
  check_phases(shape);
  // Five shapes in red, green and blue: cross 3.
  const AnnotatedEpisode both =
      play_annotated("RememberShapeAndColor5x3-VLA-v0", 4, {{"target", {11}}});
  CHECK(both.memories() == Texts{"the cue was a blue cross"});
  CHECK(both.subtasks().front() == "remember the shape and color of the object");
  check_phases(both);
}

TEST_CASE("Words of FindImposter: the one that was not shown has no name before",
          "[labels][remember]") {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const AnnotatedEpisode episode =
        play_annotated("FindImposterColor3-VLA-v0", seed, {{"imposter", {1}}});
    REQUIRE(episode.success);
    CHECK(episode.memories() == Texts{"the cue showed the red cube and the blue cube"});
    CHECK(episode.subtasks() == Texts{"remember which cubes are shown", "wait",
                                      "move to the green cube", "touch the green cube"});
    const int acts = test::appearance_of(*episode.batch);
    for (int t = 0; t < static_cast<int>(episode.frames.size()); ++t) {
      const std::string& words = episode.frames[static_cast<std::size_t>(t)].plan[kTouch];
      CHECK(words == (t < acts ? "touch the cube that was not shown" : "touch the green cube"));
    }
    check_phases(episode);
  }
}

}  // namespace
}  // namespace engram
