// Words of TraceShape and TraceShapeSeq, against what episodes draw.
#include "tasks/trace_shape/annotator.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/tasks/annotated_episode.h"

namespace engram {
namespace {

using test::AnnotatedEpisode, test::AnnotatedFrame, test::play_annotated, test::Texts;

TEST_CASE("Words of TraceShape: the shape, after its demonstration", "[labels][trace_shape]") {
  const char* const shapes[] = {"circle", "square", "triangle"};
  for (int shape = 0; shape < 3; ++shape) {
    const std::string name = shapes[shape];
    INFO(name);
    const AnnotatedEpisode episode =
        play_annotated("TraceShapeHard-VLA-v0", 3, {{"shape", {1.0 * shape}}});
    REQUIRE(episode.success);
    CHECK(episode.memories() == Texts{"", "the red cube traced a " + name});
    CHECK(episode.subtasks() ==
          Texts{"watch the red cube", "pick up the green cube", "trace the " + name});
    for (int t = 0; t < static_cast<int>(episode.frames.size()); ++t) {
      INFO("frame " << t);
      const AnnotatedFrame& frame = episode.frames[static_cast<std::size_t>(t)];
      CHECK(frame.memory.empty() == (t < episode.cue_end));
      CHECK((frame.subtask == 0) == (t < episode.cue_end));
      CHECK(frame.plan.back() == (t < episode.cue_end ? "trace the shape" : "trace the " + name));
    }
  }
}

TEST_CASE("Words of TraceShapeSeq: number and order of the shapes", "[labels][trace_shape]") {
  const AnnotatedEpisode episode = play_annotated(
      "TraceShapeSeqHard-VLA-v0", 1, {{"shapes", {2, 0, 1, 0, 0}}, {"sequence_length", {3}}});
  REQUIRE(episode.success);
  const std::string traced = "the red cube traced a triangle";
  CHECK(episode.memories() ==
        Texts{"", traced, traced + ", then a circle", traced + ", then a circle, then a square"});
  CHECK(episode.frames.front().plan == Texts{"watch the red cube", "pick up the green cube",
                                             "trace the shapes in their order",
                                             "press the button"});
  CHECK(episode.subtasks() == Texts{"watch the red cube", "pick up the green cube",
                                    "trace the triangle", "trace the circle", "trace the square",
                                    "press the button"});
  const auto props = episode.batch->physics_model().props();
  CHECK(props[static_cast<std::size_t>(episode.frames.back().object)].name ==
        "trace_shape_seq_button_cap");
}

}  // namespace
}  // namespace engram
