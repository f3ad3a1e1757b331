// Words of the shell games, against what episodes draw.
#include "tasks/shell_game/annotator.h"

#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/tasks/annotated_episode.h"

namespace engram {
namespace {

using test::AnnotatedEpisode, test::play_annotated, test::row, test::Texts;

const std::array<std::string, 3> kPlaces = {"left", "middle", "right"};
const std::array<std::string, 3> kInPlaces = {"on the left", "in the middle", "on the right"};

int remembered(const AnnotatedEpisode& episode, const char* name) {
  return *row<std::int32_t>(test::memory_of(*episode.batch).find(name), 0);
}

// The answer, by the slot that the game reports.
int answer(const AnnotatedEpisode& episode) {
  return *row<std::int32_t>(episode.batch->output("oracle_info"), 0);
}

// Frames in which no subtask of the hand is episode, and those in which one is.
void check_phases(const AnnotatedEpisode& episode, int first_skill) {
  const int acts = remembered(episode, "manipulation_start");
  const int cue = remembered(episode, "cue_steps");
  for (int t = 0; t < static_cast<int>(episode.frames.size()); ++t) {
    INFO("frame " << t);
    const int subtask = episode.frames[static_cast<std::size_t>(t)].subtask;
    CHECK((subtask == 0) == (t < cue));
    CHECK((subtask >= first_skill) == (t >= acts));
  }
}

TEST_CASE("Words of the games with a ball", "[labels][shell_game]") {
  struct Game {
    const char* id;
    Texts skill_subtasks;  // CUP stands for the cup
  };
  const std::vector<Game> games = {
      {"ShellGameTouch-VLA-v0", {"move to CUP", "touch CUP"}},
      {"ShellGamePush-VLA-v0", {"move behind CUP", "push CUP forward"}},
      {"ShellGamePick-VLA-v0",
       {"move to the handle of CUP", "grasp CUP by its handle", "lift CUP"}}};
  for (const Game& game : games) {
    for (int slot = 0; slot < 3; ++slot) {
      INFO(game.id << ", slot " << slot);
      const auto index = static_cast<std::size_t>(slot);
      const AnnotatedEpisode episode =
          play_annotated(game.id, 5, {{"cup_with_ball_number", {1.0 * slot}}});
      REQUIRE(episode.success);
      CHECK(episode.memories() == Texts{"the ball was " + kInPlaces[index]});
      Texts expected = {"remember where the ball is"};
      for (std::string skill : game.skill_subtasks) {
        expected.push_back(skill.replace(skill.find("CUP"), 3, "the " + kPlaces[index] + " cup"));
      }
      CHECK(episode.subtasks() == expected);
      const auto props = episode.batch->physics_model().props();
      CHECK(props[static_cast<std::size_t>(episode.frames.front().object)].name == "red_ball");
      CHECK(episode.frames.back().object == slot);
      check_phases(episode, 1);
    }
  }
}

TEST_CASE("Words of a shuffle: where the ball is, once it is over", "[labels][shell_game]") {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    const AnnotatedEpisode episode = play_annotated("ShellGameShuffleTouch-VLA-v0", seed);
    REQUIRE(episode.success);
    const auto first = static_cast<std::size_t>(remembered(episode, "cup_with_ball_number"));
    const auto last = static_cast<std::size_t>(answer(episode));
    const std::string seen = "the ball was " + kInPlaces[first];
    CHECK(episode.memories() ==
          Texts{seen, seen + " and is under the " + kPlaces[last] + " cup now"});
    CHECK(episode.subtasks() ==
          Texts{"remember where the ball is", "follow the cups as they are shuffled",
                "move to the " + kPlaces[last] + " cup", "touch the " + kPlaces[last] + " cup"});
    CHECK(episode.frames.front().plan.back() == "touch the cup with the ball");
    CHECK(episode.frames.back().object ==
          static_cast<int>(first));  // mugs are named by first slots
    check_phases(episode, 2);
  }
}

TEST_CASE("Words of a lamp: its color is named when it shines", "[labels][shell_game]") {
  for (const char* id :
       {"ShellGameColorLampTouch-VLA-v0", "ShellGameShuffleColorLampTouch-VLA-v0"}) {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      INFO(id << ", seed " << seed);
      const AnnotatedEpisode episode = play_annotated(id, seed);
      const auto* slots =
          row<std::uint8_t>(test::memory_of(*episode.batch).find("slot_of_color"), 0);
      const std::string cup = "the " + kPlaces[static_cast<std::size_t>(answer(episode))] + " cup";
      const Texts memories = episode.memories();
      CHECK(memories.front() == "the red ball was " + kInPlaces[slots[0]] +
                                    ", the green ball was " + kInPlaces[slots[1]] +
                                    " and the blue ball was " + kInPlaces[slots[2]]);
      const bool shuffles = std::string(id).find("Shuffle") != std::string::npos;
      CHECK(memories.size() == (shuffles ? 2U : 1U));
      const auto acts = static_cast<std::size_t>(remembered(episode, "manipulation_start"));
      for (std::size_t t = 0; t < episode.frames.size(); ++t) {
        CHECK(episode.frames[t].plan.back() ==
              "touch " + (t < acts ? "the cup with the lamp's color" : cup));
        if (t < acts) CHECK(episode.frames[t].object == -1);
      }
      check_phases(episode, shuffles ? 2 : 1);
    }
  }
}

}  // namespace
}  // namespace engram
