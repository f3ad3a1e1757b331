// Words of TraceShape and TraceShapeSeq, against what episodes draw.
#include "tasks/trace_shape/annotator.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/tasks/told_episode.h"

namespace engram {
namespace {

using test::play_told;
using test::ToldEpisode;
using test::ToldFrame;

using Texts = std::vector<std::string>;

TEST_CASE("Words of TraceShape: the shape, after its demonstration", "[labels][trace_shape]") {
  const char* const shapes[] = {"circle", "square", "triangle"};
  for (int shape = 0; shape < 3; ++shape) {
    const std::string name = shapes[shape];
    INFO(name);
    const ToldEpisode told = play_told("TraceShapeHard-VLA-v0", 3, {{"shape", {1.0 * shape}}});
    REQUIRE(told.success);
    CHECK(told.memories() == Texts{"", "the red cube traced a " + name});
    CHECK(told.subtasks() ==
          Texts{"watch the red cube", "pick up the green cube", "trace the " + name});
    for (int t = 0; t < static_cast<int>(told.frames.size()); ++t) {
      INFO("frame " << t);
      const ToldFrame& frame = told.frames[static_cast<std::size_t>(t)];
      CHECK(frame.memory.empty() == (t < told.cue_end));
      CHECK((frame.subtask == 0) == (t < told.cue_end));
      CHECK(frame.plan.back() == (t < told.cue_end ? "trace the shape" : "trace the " + name));
    }
  }
}

TEST_CASE("Words of TraceShapeSeq: number and order of the shapes", "[labels][trace_shape]") {
  const ToldEpisode told = play_told("TraceShapeSeqHard-VLA-v0", 1,
                                     {{"shapes", {2, 0, 1, 0, 0}}, {"sequence_length", {3}}});
  REQUIRE(told.success);
  const std::string traced = "the red cube traced a triangle";
  CHECK(told.memories() ==
        Texts{"", traced, traced + ", then a circle", traced + ", then a circle, then a square"});
  CHECK(told.frames.front().plan == Texts{"watch the red cube", "pick up the green cube",
                                          "trace the shapes in their order", "press the button"});
  CHECK(told.subtasks() == Texts{"watch the red cube", "pick up the green cube",
                                 "trace the triangle", "trace the circle", "trace the square",
                                 "press the button"});
  const auto props = told.env->physics_model().props();
  CHECK(props[static_cast<std::size_t>(told.frames.back().object)].name ==
        "trace_shape_seq_button_cap");
}

}  // namespace
}  // namespace engram
