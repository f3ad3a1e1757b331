// Words of BunchOfColors, SeqOfColors and ChainOfColors, against what episodes draw.
#include "tasks/colors/annotator.h"

#include <algorithm>
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

constexpr int kFirstTouch = 2;

// Colours 4, 1 and 7 in a cue of two steps each, or of two steps at once.
std::vector<Pin> pins(const char* cue) {
  return {{"sequence", {4, 1, 7}}, {cue, {2}}, {"empty_steps", {3}}};
}

const ToldFrame& at_frame(const ToldEpisode& told, int t) {
  return told.frames[static_cast<std::size_t>(t)];
}

// The cubes touched so far are done, whatever the order.
void check_touches(const ToldEpisode& told) {
  REQUIRE(told.success);
  const ToldFrame& last = told.frames.back();
  CHECK(last.plan == Texts{last.plan[0], "wait", "touch the magenta cube", "touch the green cube",
                           "touch the orange cube", "press the center button"});
  CHECK(last.words() == "press the center button");
  CHECK(last.done == 5);
  int done = 0;
  for (const ToldFrame& frame : told.frames) {
    CHECK(frame.done >= done);
    done = frame.done;
    if (frame.subtask >= kFirstTouch && frame.subtask < kFirstTouch + 3) {
      const int colors[] = {4, 1, 7};
      CHECK(frame.object == colors[frame.subtask - kFirstTouch]);
    }
  }
  const auto props = told.env->physics_model().props();
  CHECK(props[static_cast<std::size_t>(last.object)].name == "center_button_cap");
}

TEST_CASE("Words of ChainOfColors: color by color, in order", "[labels][colors]") {
  const ToldEpisode told = play_told("ChainOfColors3-VLA-v0", 1, pins("cue_step_duration"));
  check_touches(told);
  const std::string before = "the cubes of the cue in their order: ";
  CHECK(told.memories() == Texts{before + "magenta", before + "magenta, then green",
                                 before + "magenta, then green, then orange"});
  CHECK(at_frame(told, 0).memory == before + "magenta");
  CHECK(at_frame(told, 1).memory == before + "magenta");
  CHECK(at_frame(told, 2).memory == before + "magenta, then green");
  CHECK(at_frame(told, 4).memory == before + "magenta, then green, then orange");
  CHECK(at_frame(told, 0).plan[3] == "touch cube 2 of the cue");
  CHECK(at_frame(told, 2).plan[3] == "touch the green cube");
  CHECK(at_frame(told, 2).plan[4] == "touch cube 3 of the cue");
  CHECK(at_frame(told, 2).object == 1);
  CHECK(at_frame(told, 5).subtask == 0);
  CHECK(at_frame(told, 6).subtask == 1);
  CHECK(at_frame(told, 9).subtask == 2);
  // In the order of the cue, each once.
  CHECK(told.subtasks() == Texts{"remember the colors of the cubes and their order", "wait",
                                 "touch the magenta cube", "touch the green cube",
                                 "touch the orange cube", "press the center button"});
}

TEST_CASE("Words of SeqOfColors and BunchOfColors: any order", "[labels][colors]") {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const ToldEpisode seq = play_told("SeqOfColors3-VLA-v0", seed, pins("cue_step_duration"));
    check_touches(seq);
    const std::string before = "the cubes of the cue: ";
    CHECK(seq.memories() == Texts{before + "magenta", before + "magenta and green",
                                  before + "magenta, green and orange"});
    const ToldEpisode bunch = play_told("BunchOfColors3-VLA-v0", seed, pins("cue_steps"));
    check_touches(bunch);
    CHECK(bunch.memories() == Texts{before + "magenta, green and orange"});
    CHECK(at_frame(bunch, 0).object == -1);
    CHECK(at_frame(bunch, 2).subtask == 1);
    CHECK(at_frame(bunch, 5).subtask >= kFirstTouch);
    Texts told = bunch.subtasks();
    CHECK(told.size() == 6);
  }
}

}  // namespace
}  // namespace engram
