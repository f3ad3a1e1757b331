// What holds in every step of every task, whoever plays: success has its geometric conditions,
// rewards stay in their ranges, and nothing that only goes forward ever goes back.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <map>
#include <memory>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "tasks/family_samples.h"
#include "tests/build_paths.h"
#include "tests/env_helpers.h"
#include "tests/tasks/benchmark_table.h"
#include "tests/tasks/success_conditions.h"

namespace engram {
namespace {

using test::Judge, test::make_env, test::Spectator, test::Timing;

// --- playing ---

constexpr std::uint64_t kSeed = 20;

// The lengths of the phases, where they are drawn, a little above the least.
constexpr std::array kLengths = {"cue_steps", "cue_step_duration", "empty_steps", "shuffle_steps"};

std::vector<Pin> length_pins(const TaskInfo& info) {
  std::vector<Pin> pins;
  for (const RandomVariable& draw : info.random_variables) {
    if (std::find(kLengths.begin(), kLengths.end(), draw.name) == kLengths.end()) continue;
    pins.push_back({draw.name, {std::min(draw.low + 1, draw.high)}});
  }
  return pins;
}

Timing timing_of(const TaskInfo& info) {
  Timing timing;
  for (const Pin& pin : length_pins(info)) {
    int steps = static_cast<int>(pin.values.front());
    if (pin.name == "cue_step_duration") steps *= info.oracle_dim;  // one item after the other
    timing.begin += steps;
    if (pin.name.starts_with("cue")) timing.cue_end = steps;
  }
  return timing;
}

std::unique_ptr<Batch> make_play(const std::string& id) {
  return make_env(id, {.num_envs = require_entry(id).horizon > 300 ? 2 : 4,
                       .seed = kSeed,
                       .auto_reset = AutoReset::kOff,
                       .pins = length_pins(make_task(id)->info())});
}

// Even environments are played by the oracle, odd ones at random.
void step_mixed(Batch& batch) {
  std::vector<float> actions = test::act(batch, Policy::kRandom);
  const std::vector<float> oracle = test::act(batch, Policy::kOracle);
  for (int i = 0; i < batch.num_envs(); i += 2) {
    const auto begin = static_cast<std::ptrdiff_t>(i) * batch.action_dim();
    std::copy_n(oracle.begin() + begin, batch.action_dim(), actions.begin() + begin);
  }
  batch.step(actions);
}

// Something that looks on while one environment plays an episode.
struct Watch {
  virtual ~Watch() = default;
  virtual void look(const Spectator& scene) = 0;
};

[[noreturn]] void complain(const Spectator& scene, const std::string& what) {
  FAIL("environment " << scene.index() << ", step " << scene.elapsed() << ": " << what);
  throw;
}

// --- success ---

// Families in which the oracle has solved something while these tests looked on.
std::map<std::string, int> solved;

struct SuccessWatch : Watch {
  SuccessWatch(const TaskInfo& info)
      : judge(test::make_judge(info.family, timing_of(info), info.split == "rl")) {
    // A task of a user's own has its conditions of success in its own test.
    if (judge == nullptr && test::is_benchmark_id(info.id)) {
      FAIL("no success condition for " << info.family);
    }
    solved.emplace(info.family, 0);
  }
  void look(const Spectator& scene) override {
    if (judge == nullptr) return;
    const bool holds = judge->holds(scene);
    if (scene.success() && !holds) complain(scene, "success without its conditions");
    if (judge->exact() && holds && !scene.success()) complain(scene, "conditions without success");
  }
  std::unique_ptr<Judge> judge;
};

// --- rewards ---

const Expectations& expectations_of(const std::string& id) {
  return require_entry(id).definition->expectations;
}

struct RewardRange {
  std::string ids;  // what they begin with
  double least = 0;
  double most = 0;
};

// A table of docs/tasks/README.md, the one of the VLA ids or of the RL ids.
std::vector<RewardRange> documented_ranges(bool rl) {
  std::ifstream file(std::string(test::kRoot) + "/docs/tasks/README.md");
  std::vector<RewardRange> ranges;
  bool of_rl = false;
  for (std::string line; std::getline(file, line);) {
    of_rl = of_rl || line.starts_with("| RL ids");
    std::istringstream cells(line);
    RewardRange range;
    char bar = 0;
    char second = 0;
    char third = 0;
    if (of_rl == rl && cells >> bar >> range.ids >> second >> range.least >> third >> range.most &&
        bar == '|' && second == '|' && third == '|') {
      ranges.push_back(range);
    }
  }
  return ranges;
}

// The range of a task's normalised reward. RL tasks have that of their family, unless the docs say
// another one.
RewardRange reward_range(const TaskInfo& info) {
  if (info.split == "rl") {
    for (const RewardRange& range : documented_ranges(true)) {
      if (info.id.starts_with(range.ids)) return range;
    }
  }
  const Expectations& expected = expectations_of(info.id);
  return {info.family, expected.min_reward, expected.max_reward};
}

struct RewardWatch : Watch {
  RewardWatch(const Batch& watched) : batch(watched), range(reward_range(watched.info())) {}
  void look(const Spectator& scene) override {
    const float reward = batch.outputs().reward[static_cast<std::size_t>(scene.index())];
    if (scene.elapsed() > 0) sum += static_cast<double>(reward);
    const bool good = scene.elapsed() == 0 ? reward == 0
                      : scene.success()    ? reward == 1
                                           : reward >= static_cast<float>(range.least) &&
                                              reward <= static_cast<float>(range.most);
    // Not a number is in no range.
    if (!good) complain(scene, "reward " + std::to_string(reward));
    if (scene.info("episode_return") != sum) complain(scene, "return is not the sum of rewards");
  }
  const Batch& batch;
  RewardRange range;
  double sum = 0;
};

// --- order ---

// Info fields that only ever grow within an episode, or switch on for good; and the contrary.
constexpr std::array kGrowing = {"elapsed_steps",       "success_once",
                                 "action_mask",         "phase_ready",
                                 "button_pressed",      "submit_attempted",
                                 "submit_success",      "submit_success_latched",
                                 "goal_reached_status", "checkpoint_visited",
                                 "visit_fraction",      "all_visited",
                                 "sequence_progress",   "all_shapes_closed",
                                 "active_shape_idx",    "press_count",
                                 "raw_press_count",     "too_early",
                                 "signal_on",           "past_window",
                                 "n_on_disc",           "flash_triggered",
                                 "checked_count",       "found_working_count",
                                 "all_checked",         "failed"};
constexpr std::array kShrinking = {"pre_demo_mask", "cue_mask"};
constexpr std::array kConstant = {"target_blinks", "flash_color", "active_battery_count",
                                  "target_working_count"};

struct OrderWatch : Watch {
  OrderWatch(const Batch& batch) {
    add(batch, kGrowing, 1);
    add(batch, kShrinking, -1);
    add(batch, kConstant, 0);
  }
  template <class Names>
  void add(const Batch& batch, const Names& names, int direction) {
    for (const char* name : names) {
      if (test::columns_of(batch).find(name).field != nullptr)
        fields.push_back({name, direction, {}});
    }
  }
  void look(const Spectator& scene) override {
    for (Entry& entry : fields) {
      const int width = scene.width(entry.name);
      for (int i = 0; i < width; ++i) {
        const double value = scene.info(entry.name, i);
        if (static_cast<int>(entry.last.size()) == i) entry.last.push_back(value);
        double& last = entry.last[static_cast<std::size_t>(i)];
        const bool good = entry.direction > 0   ? value >= last
                          : entry.direction < 0 ? value <= last
                                                : value == last;
        if (!good) complain(scene, std::string(entry.name) + " went back");
        last = value;
      }
    }
  }
  struct Entry {
    const char* name;
    int direction;
    std::vector<double> last;
  };
  std::vector<Entry> fields;
};

// How many props of a kind are to be seen, before `cue_end`, up to `begin`, and from then on.
struct Visible {
  std::string_view family;
  const char* prefix;
  int cue;
  int empty;
  int action;
};
constexpr int kAll = 1000;
constexpr int kAllButOne = 999;
constexpr int kAsked = 998;  // as many as the episode asks for
constexpr std::array kVisible = {
    Visible{"Remember", "", 1, 0, kAll},
    Visible{"FindImposter", "", kAllButOne, 0, kAll},
    Visible{"ShellGame", "mug_", 0, kAll, kAll},
    Visible{"ShellGameShuffleTouch", "red_ball", 1, 0, 1},
    Visible{"ShellGameTouch", "red_ball", 1, 1, 1},
    Visible{"ShellGameColorLamp", "ball_", kAll, 0, 0},
    Visible{"ShellGameShuffleColorLamp", "ball_", kAll, 0, 0},
    Visible{"BunchOfColors", "cube_", kAsked, 0, kAll},
    Visible{"SeqOfColors", "cube_", 1, 0, kAll},
    Visible{"ChainOfColors", "cube_", 1, 0, kAll},
};

// Each phase shows what it shows, from its first step to its last.
struct PhaseWatch : Watch {
  PhaseWatch(const TaskInfo& info) : timing(timing_of(info)), asked(info.oracle_dim) {
    for (const Visible& row : kVisible) {
      if (info.family.starts_with(row.family)) rows.push_back(row);
    }
  }
  void look(const Spectator& scene) override {
    for (const Visible& row : rows) {
      const std::vector<int> props = scene.props(row.prefix);
      const auto shown =
          std::count_if(props.begin(), props.end(), [&](int prop) { return !scene.hidden(prop); });
      const auto all = static_cast<int>(props.size());
      int wanted = scene.elapsed() < timing.cue_end ? row.cue
                   : scene.elapsed() < timing.begin ? row.empty
                                                    : row.action;
      if (wanted == kAll) wanted = all;
      if (wanted == kAllButOne) wanted = all - 1;
      if (wanted == kAsked) wanted = asked;
      if (shown != wanted) {
        complain(scene, std::to_string(shown) + " of " + row.prefix + "* are shown, not " +
                            std::to_string(wanted));
      }
    }
  }
  Timing timing;
  int asked;
  std::vector<Visible> rows;
};

// --- all of it ---

void watch_episodes(const std::string& id) {
  INFO(id);
  const auto batch = make_play(id);
  const auto num_envs = static_cast<std::size_t>(batch->num_envs());
  std::vector<std::vector<std::unique_ptr<Watch>>> watches(num_envs);
  for (auto& list : watches) {
    list.push_back(std::make_unique<SuccessWatch>(batch->info()));
    list.push_back(std::make_unique<RewardWatch>(*batch));
    list.push_back(std::make_unique<OrderWatch>(*batch));
    list.push_back(std::make_unique<PhaseWatch>(batch->info()));
  }
  batch->reset();
  std::vector<bool> over(num_envs);
  const auto look = [&] {
    for (int i = 0; i < batch->num_envs(); ++i) {
      const auto index = static_cast<std::size_t>(i);
      if (over[index]) continue;
      const Spectator scene(*batch, i);
      for (const auto& watch : watches[index]) watch->look(scene);
      over[index] = scene.finished();
      if (over[index] && i % 2 == 0) solved[batch->info().family] += scene.info_int("success_once");
    }
  };
  look();
  while (std::find(over.begin(), over.end(), false) != over.end()) {
    step_mixed(*batch);
    look();
  }
  CHECK(Queries(*batch).unstable_count() == 0);
}

TEST_CASE("Whole episodes of every task keep what the spec promises", "[properties]") {
  solved.clear();
  for (const std::string& id : test::implemented_ids()) watch_episodes(id);
  // No condition of success has gone untested.
  for (const auto& [family, episodes] : solved) {
    INFO(family);
    CHECK(episodes > 0);
  }
}

TEST_CASE("docs/tasks/README.md says what the tasks expect of rewards", "[properties]") {
  const std::vector<RewardRange> ranges = documented_ranges(false);
  std::set<std::string> used;
  for (const test::BenchmarkRow& row : test::benchmark()) {
    const std::string& id = row[0];
    INFO(id);
    const auto range =
        std::ranges::find_if(ranges, [&](const RewardRange& r) { return id.starts_with(r.ids); });
    REQUIRE(range != ranges.end());
    CHECK(range->least == expectations_of(id).min_reward);
    CHECK(range->most == expectations_of(id).max_reward);
    CHECK(range->least < range->most);
    used.insert(range->ids);
  }
  CHECK(used.size() == ranges.size());
}

// Plays equal steps in all modes: the mode scales the reward and changes nothing else.
void compare_modes(const std::string& id, int steps) {
  INFO(id);
  BatchOptions options{.num_envs = 2, .seed = kSeed, .auto_reset = AutoReset::kOff};
  std::array<std::unique_ptr<Batch>, 4> envs;
  for (std::size_t i = 0; i < envs.size(); ++i) {
    options.reward_mode = static_cast<RewardMode>(i);
    envs[i] = make_env(id, options);
    envs[i]->reset();
  }
  const auto& [none, sparse, dense, normalized] = envs;
  const auto bonus = static_cast<float>(none->info().success_reward);
  for (int step = 0; step < steps; ++step) {
    const std::array<bool, 2> over = {dense->state().finished[0] != 0,
                                      dense->state().finished[1] != 0};
    for (const auto& batch : envs) step_mixed(*batch);
    for (std::size_t i = 0; i < 2; ++i) {
      if (over[i]) continue;  // keeps its success, but earns nothing any more
      const float success = dense->outputs().success[i];
      REQUIRE(none->outputs().reward[i] == 0);
      REQUIRE(sparse->outputs().reward[i] == success);
      REQUIRE(std::isfinite(dense->outputs().reward[i]));
      REQUIRE(normalized->outputs().reward[i] == dense->outputs().reward[i] / bonus);
      if (success != 0) REQUIRE(dense->outputs().reward[i] == bonus);
    }
    for (const auto& batch : envs)
      REQUIRE(std::ranges::equal(batch->outputs().observation, dense->outputs().observation));
  }
}

TEST_CASE("Reward modes scale the same reward and leave the episode alone", "[properties]") {
  for (const std::string& id : one_of_each_family()) compare_modes(id, 40);
}

TEST_CASE("Reward modes scale the same reward in whole episodes of every task",
          "[properties][long]") {
  for (const std::string& id : test::implemented_ids()) {
    compare_modes(id, require_entry(id).horizon);
  }
}

}  // namespace
}  // namespace engram
