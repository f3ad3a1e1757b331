// Words of BunchOfColors, SeqOfColors and ChainOfColors, against what episodes draw.
#include "tasks/colors/annotator.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/tasks/annotated_episode.h"

namespace engram {
namespace {

using test::AnnotatedEpisode, test::AnnotatedFrame, test::play_annotated, test::row, test::Texts;

constexpr int kFirstTouch = 2;

// Colours 4, 1 and 7 in a cue of two steps each, or of two steps at once.
std::vector<Pin> pins(const char* cue) {
  return {{"sequence", {4, 1, 7}}, {cue, {2}}, {"empty_steps", {3}}};
}

const AnnotatedFrame& at_frame(const AnnotatedEpisode& episode, int t) {
  return episode.frames[static_cast<std::size_t>(t)];
}

// The cubes touched so far are done, whatever the order.
void check_touches(const AnnotatedEpisode& episode) {
  REQUIRE(episode.success);
  const AnnotatedFrame& last = episode.frames.back();
  CHECK(last.plan == Texts{last.plan[0], "wait", "touch the magenta cube", "touch the green cube",
                           "touch the orange cube", "press the center button"});
  CHECK(last.words() == "press the center button");
  CHECK(last.done == 5);
  int done = 0;
  for (const AnnotatedFrame& frame : episode.frames) {
    CHECK(frame.done >= done);
    done = frame.done;
    if (frame.subtask >= kFirstTouch && frame.subtask < kFirstTouch + 3) {
      const int colors[] = {4, 1, 7};
      CHECK(frame.object == colors[frame.subtask - kFirstTouch]);
    }
  }
  const auto props = episode.batch->physics_model().props();
  CHECK(props[static_cast<std::size_t>(last.object)].name == "center_button_cap");
}

TEST_CASE("Words of ChainOfColors: color by color, in order", "[labels][colors]") {
  const AnnotatedEpisode episode =
      play_annotated("ChainOfColors3-VLA-v0", 1, pins("cue_step_duration"));
  check_touches(episode);
  const std::string before = "the cubes of the cue in their order: ";
  CHECK(episode.memories() == Texts{before + "magenta", before + "magenta, then green",
                                    before + "magenta, then green, then orange"});
  CHECK(at_frame(episode, 0).memory == before + "magenta");
  CHECK(at_frame(episode, 1).memory == before + "magenta");
  CHECK(at_frame(episode, 2).memory == before + "magenta, then green");
  CHECK(at_frame(episode, 4).memory == before + "magenta, then green, then orange");
  CHECK(at_frame(episode, 0).plan[3] == "touch cube 2 of the cue");
  CHECK(at_frame(episode, 2).plan[3] == "touch the green cube");
  CHECK(at_frame(episode, 2).plan[4] == "touch cube 3 of the cue");
  CHECK(at_frame(episode, 2).object == 1);
  CHECK(at_frame(episode, 5).subtask == 0);
  CHECK(at_frame(episode, 6).subtask == 1);
  CHECK(at_frame(episode, 9).subtask == 2);
  // In the order of the cue, each once.
  CHECK(episode.subtasks() == Texts{"remember the colors of the cubes and their order", "wait",
                                    "touch the magenta cube", "touch the green cube",
                                    "touch the orange cube", "press the center button"});
}

TEST_CASE("Words of SeqOfColors and BunchOfColors: any order", "[labels][colors]") {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const AnnotatedEpisode seq =
        play_annotated("SeqOfColors3-VLA-v0", seed, pins("cue_step_duration"));
    check_touches(seq);
    const std::string before = "the cubes of the cue: ";
    CHECK(seq.memories() == Texts{before + "magenta", before + "magenta and green",
                                  before + "magenta, green and orange"});
    const AnnotatedEpisode bunch = play_annotated("BunchOfColors3-VLA-v0", seed, pins("cue_steps"));
    check_touches(bunch);
    CHECK(bunch.memories() == Texts{before + "magenta, green and orange"});
    CHECK(at_frame(bunch, 0).object == -1);
    CHECK(at_frame(bunch, 2).subtask == 1);
    CHECK(at_frame(bunch, 5).subtask >= kFirstTouch);
    Texts episode = bunch.subtasks();
    CHECK(episode.size() == 6);
  }
}

TEST_CASE("Words of the RL tasks end with the last touch", "[labels][colors][rl]") {
  for (const char* family : {"BunchOfColors", "SeqOfColors", "ChainOfColors"}) {
    INFO(family);
    const AnnotatedEpisode episode =
        play_annotated(std::string(family) + "3-v0", 1, {{"sequence", {4, 1, 7}}});
    REQUIRE(episode.success);
    CHECK(at_frame(episode, 0).subtask == 0);
    const AnnotatedFrame& last = episode.frames.back();
    CHECK(last.plan == Texts{last.plan[0], "wait", "touch the magenta cube", "touch the green cube",
                             "touch the orange cube"});
    CHECK(episode.end.done == 4);
    Texts words = episode.subtasks();
    CHECK(words.size() == 5);
    if (family[0] == 'C') {
      CHECK(words.back() == "touch the orange cube");
      CHECK(last.object == 7);
    }
  }
}

}  // namespace
}  // namespace engram
