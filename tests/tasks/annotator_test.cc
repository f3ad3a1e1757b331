// What holds of the words of all families.
#include "core/task/annotator.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <set>
#include <string>
#include <vector>

#include "protocol/make/make.h"
#include "tasks/family_samples.h"
#include "tests/tasks/annotated_episode.h"

namespace engram {
namespace {

using test::AnnotatedEpisode, test::AnnotatedFrame, test::play_annotated;

// One short task of every family.
std::vector<std::string> sample_ids() {
  std::vector<std::string> ids;
  std::set<std::string> families;
  for (const RegistryEntry& entry : registry()) {
    if (entry.horizon > 400 || !families.emplace(entry.family).second) continue;
    ids.emplace_back(entry.id);
  }
  return ids;
}

TEST_CASE("Words: subtasks follow one another up to the last", "[labels]") {
  for (const std::string& id : sample_ids()) {
    INFO(id);
    const bool has_spare_checks = id.starts_with("Batteries");  // ends when all are found
    for (const std::uint64_t seed : {1U, 2U}) {
      const AnnotatedEpisode episode = play_annotated(id, seed);
      if (!episode.success) continue;
      const int props = static_cast<int>(episode.batch->physics_model().props().size());
      std::set<int> visited;
      int max_done = 0;
      for (const AnnotatedFrame& frame : episode.frames) {
        const int length = static_cast<int>(frame.plan.size());
        REQUIRE(length > 1);
        REQUIRE((frame.subtask >= 0 && frame.subtask < length));
        REQUIRE((frame.done >= 0 && frame.done <= length));
        REQUIRE((frame.object >= -1 && frame.object < props));
        for (const std::string& words : frame.plan) {
          CHECK((std::islower(words.front()) != 0 && std::isalnum(words.back()) != 0));
        }
        visited.insert(frame.subtask);
        max_done = std::max(max_done, frame.done);
      }
      const int last = static_cast<int>(episode.frames.back().plan.size()) - 1;
      CHECK(episode.frames.front().subtask == 0);
      if (has_spare_checks) continue;
      CHECK(max_done <= last);
      CHECK(episode.end.subtask == last);
      CHECK(episode.end.done == last);
    }
  }
}

// Two episodes that differ in what is hidden, and in nothing else.
struct Twins {
  const char* id;
  const char* variable;
  std::vector<double> one;
  std::vector<double> other;
};

TEST_CASE("Words: nothing is episode before an image shows it", "[labels]") {
  const std::vector<Twins> twins = {
      {"RememberColor5-VLA-v0", "target", {1}, {3}},
      {"FindImposterShape5-VLA-v0", "imposter", {0}, {4}},
      {"ShellGameTouch-VLA-v0", "cup_with_ball_number", {0}, {2}},
      {"ShellGameColorLampTouch-VLA-v0", "target_color", {0}, {1}},
      {"ShellGameShuffleColorLampTouch-VLA-v0", "target_color", {0}, {2}},
      {"ShellGameShuffleTouch-VLA-v0", "cup_with_ball_number", {0}, {1}},
      {"SeqOfColors3-VLA-v0", "sequence", {4, 1, 7}, {4, 1, 2}},
      {"ChainOfColors3-VLA-v0", "sequence", {4, 1, 7}, {4, 7, 1}},
      {"BunchOfColors3-VLA-v0", "sequence", {4, 1, 7}, {4, 1, 2}},
      {"SeqOfColors3-v0", "sequence", {4, 1, 7}, {4, 1, 2}},
      {"ChainOfColors3-v0", "sequence", {4, 1, 7}, {4, 7, 1}},
      {"BunchOfColors3-v0", "sequence", {4, 1, 7}, {4, 1, 2}},
      {"BlinkCountButtonPressEasy-VLA-v0", "target_blinks", {1}, {3}},
      {"TimedTransferEasy-VLA-v0", "signal_step", {1}, {3}},
      {"GatherAndRecall1-VLA-v0", "flash_color", {0}, {2}},
      {"BatteriesCheckerEasy-3-VLA-v0", "working", {1}, {2}},
      {"TraceShapeHard-VLA-v0", "shape", {0}, {1}},
      {"TakeItBack-VLA-v0", "slot", {-1}, {1}},
  };
  int all_alike = 0;
  for (const auto& [id, variable, one, other] : twins) {
    INFO(id);
    const auto twin = [task = id, name = variable](const std::vector<double>& value) {
      MakeOptions options;
      options.seed = 7;
      options.threads = 1;
      options.obs_mode = ObsMode::kRgb;
      options.auto_reset = AutoReset::kOff;
      options.pins = {{name, value}};
      auto batch = make(task, options);
      batch->reset();
      return batch;
    };
    const auto first = twin(one);
    const auto second = twin(other);
    int alike = 0;
    while (std::ranges::equal(first->images().rgb, second->images().rgb)) {
      INFO(alike);
      REQUIRE(test::annotate(*first) == test::annotate(*second));
      REQUIRE((first->outputs().terminated[0] | first->outputs().truncated[0]) == 0);
      ++alike;
      test::step(*first, Policy::kOracle);
      test::step(*second, Policy::kOracle);
    }
    // In the end they are episode apart.
    bool differ = !(test::annotate(*first) == test::annotate(*second));
    while (!differ && (first->outputs().terminated[0] | first->outputs().truncated[0] |
                       second->outputs().terminated[0] | second->outputs().truncated[0]) == 0) {
      test::step(*first, Policy::kOracle);
      test::step(*second, Policy::kOracle);
      differ = !(test::annotate(*first) == test::annotate(*second));
    }
    CHECK(differ);
    all_alike += alike;
  }
  CHECK(all_alike > 200);  // frames that could have episode too much
}

}  // namespace
}  // namespace engram
