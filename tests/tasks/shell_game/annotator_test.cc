// Words of the shell games, against what episodes draw.
#include "tasks/shell_game/annotator.h"

#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/tasks/told_episode.h"

namespace engram {
namespace {

using test::play_told;
using test::row;
using test::ToldEpisode;

using Texts = std::vector<std::string>;

const std::array<std::string, 3> kPlaces = {"left", "middle", "right"};
const std::array<std::string, 3> kInPlaces = {"on the left", "in the middle", "on the right"};

int remembered(const ToldEpisode& told, const char* name) {
  return *row<std::int32_t>(told.env->memory().find(name), 0);
}

// The answer, by the slot that the game reports.
int answer(const ToldEpisode& told) {
  return *row<std::int32_t>(told.env->output("oracle_info"), 0);
}

// Frames in which no subtask of the hand is told, and those in which one is.
void check_phases(const ToldEpisode& told, int first_deed) {
  const int acts = remembered(told, "manipulation_start");
  const int cue = remembered(told, "cue_steps");
  for (int t = 0; t < static_cast<int>(told.frames.size()); ++t) {
    INFO("frame " << t);
    const int subtask = told.frames[static_cast<std::size_t>(t)].subtask;
    CHECK((subtask == 0) == (t < cue));
    CHECK((subtask >= first_deed) == (t >= acts));
  }
}

TEST_CASE("Words of the games with a ball", "[labels][shell_game]") {
  struct Game {
    const char* id;
    Texts deeds;  // CUP stands for the cup
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
      const ToldEpisode told = play_told(game.id, 5, {{"cup_with_ball_number", {1.0 * slot}}});
      REQUIRE(told.success);
      CHECK(told.memories() == Texts{"the ball was " + kInPlaces[index]});
      Texts expected = {"remember where the ball is"};
      for (std::string deed : game.deeds) {
        expected.push_back(deed.replace(deed.find("CUP"), 3, "the " + kPlaces[index] + " cup"));
      }
      CHECK(told.subtasks() == expected);
      const auto props = told.env->physics_model().props();
      CHECK(props[static_cast<std::size_t>(told.frames.front().object)].name == "red_ball");
      CHECK(told.frames.back().object == slot);
      check_phases(told, 1);
    }
  }
}

TEST_CASE("Words of a shuffle: where the ball is, once it is over", "[labels][shell_game]") {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    const ToldEpisode told = play_told("ShellGameShuffleTouch-VLA-v0", seed);
    REQUIRE(told.success);
    const auto first = static_cast<std::size_t>(remembered(told, "cup_with_ball_number"));
    const auto last = static_cast<std::size_t>(answer(told));
    const std::string seen = "the ball was " + kInPlaces[first];
    CHECK(told.memories() == Texts{seen, seen + " and is under the " + kPlaces[last] + " cup now"});
    CHECK(told.subtasks() ==
          Texts{"remember where the ball is", "follow the cups as they are shuffled",
                "move to the " + kPlaces[last] + " cup", "touch the " + kPlaces[last] + " cup"});
    CHECK(told.frames.front().plan.back() == "touch the cup with the ball");
    CHECK(told.frames.back().object == static_cast<int>(first));  // mugs are named by first slots
    check_phases(told, 2);
  }
}

TEST_CASE("Words of a lamp: its color is named when it shines", "[labels][shell_game]") {
  for (const char* id :
       {"ShellGameColorLampTouch-VLA-v0", "ShellGameShuffleColorLampTouch-VLA-v0"}) {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      INFO(id << ", seed " << seed);
      const ToldEpisode told = play_told(id, seed);
      const auto* slots = row<std::uint8_t>(told.env->memory().find("slot_of_color"), 0);
      const std::string cup = "the " + kPlaces[static_cast<std::size_t>(answer(told))] + " cup";
      const Texts memories = told.memories();
      CHECK(memories.front() == "the red ball was " + kInPlaces[slots[0]] +
                                    ", the green ball was " + kInPlaces[slots[1]] +
                                    " and the blue ball was " + kInPlaces[slots[2]]);
      const bool shuffles = std::string(id).find("Shuffle") != std::string::npos;
      CHECK(memories.size() == (shuffles ? 2U : 1U));
      const auto acts = static_cast<std::size_t>(remembered(told, "manipulation_start"));
      for (std::size_t t = 0; t < told.frames.size(); ++t) {
        CHECK(told.frames[t].plan.back() ==
              "touch " + (t < acts ? "the cup with the lamp's color" : cup));
        if (t < acts) CHECK(told.frames[t].object == -1);
      }
      check_phases(told, shuffles ? 2 : 1);
    }
  }
}

}  // namespace
}  // namespace engram
