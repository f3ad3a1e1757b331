// The objects observation: everything that a camera can show, and nothing else.
#include "core/observe/object_tokens.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "core/batch/snapshot.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using Layout = ObjectTokens::Layout;
using test::make_env, test::make_running;

std::unique_ptr<Batch> make_seeing(std::string_view id, MakeOptions options = {}) {
  options.obs_mode = ObsMode::kObjects;
  return make_running(id, options);
}

// The tokens of one environment: the last part of its row.
std::vector<std::vector<float>> tokens_of(const Batch& batch, int index = 0) {
  const auto width = static_cast<std::size_t>(batch.state_dim());
  const std::span<const float> row =
      batch.outputs().observation.subspan(static_cast<std::size_t>(index) * width, width);
  std::size_t begin = 0;
  for (const Field& field : Queries(batch).state_fields()) {
    if (field.name == "object_0_seen") break;
    begin += static_cast<std::size_t>(field.width);
  }
  std::vector<std::vector<float>> tokens;
  for (; begin < width; begin += Layout::kWidth) {
    const auto first = row.begin() + static_cast<std::ptrdiff_t>(begin);
    tokens.emplace_back(first, first + Layout::kWidth);
  }
  return tokens;
}

bool is_seen(const std::vector<float>& token) { return token[Layout::kSeen] == 1; }

int one_hot(const std::vector<float>& token, int begin, std::size_t width) {
  const auto first = token.begin() + begin;
  const auto last = first + static_cast<std::ptrdiff_t>(width);
  CHECK(std::count(first, last, 0.0F) + std::count(first, last, 1.0F) ==
        static_cast<std::ptrdiff_t>(width));
  REQUIRE(std::count(first, last, 1.0F) == 1);
  return static_cast<int>(std::find(first, last, 1.0F) - first);
}

int color_of(const std::vector<float>& token) {
  return one_hot(token, Layout::kColor, kObjectColorNames.size());
}

TEST_CASE("Tokens say where the cubes of RememberColor stand, and which they are", "[objects]") {
  MakeOptions options;
  options.pins = {{"target", {2}}, {"cue_steps", {2}}, {"empty_steps", {2}}};
  const auto batch = make_seeing("RememberColor9-VLA-v0", options);
  for (int t = 0; t < 6; ++t) {
    const auto tokens = tokens_of(*batch);
    REQUIRE(tokens.size() == 9);
    const auto seen = std::ranges::count_if(tokens, is_seen);
    CHECK(seen == (t < 2 ? 1 : t < 4 ? 0 : 9));
    std::set<int> colors;
    for (const auto& token : tokens) {
      if (!is_seen(token)) {
        CHECK(std::ranges::all_of(token, [](float value) { return value == 0; }));
        continue;
      }
      const int color = color_of(token);
      CHECK(colors.insert(color).second);
      CHECK(one_hot(token, Layout::kShape, kObjectShapeNames.size()) == 0);
      CHECK(one_hot(token, Layout::kKind, kObjectKindNames.size()) == 0);
      const double* pos = batch->state().prop_pos_of(0, color);  // both list colours alike
      for (int i = 0; i < 3; ++i) {
        CHECK(static_cast<double>(token[static_cast<std::size_t>(Layout::kPosition + i)]) ==
              Approx(pos[i] / 0.5).margin(1e-6));
        CHECK(token[static_cast<std::size_t>(Layout::kSize + i)] == Approx(0.02 / 0.05));
      }
    }
    if (t < 2) CHECK(colors == std::set<int>{2});
    test::step(*batch, Policy::kZero);
  }
}

TEST_CASE("The order of tokens is drawn anew when something appears", "[objects]") {
  MakeOptions options;
  options.num_envs = 64;
  options.pins = {{"target", {0}}, {"cue_steps", {1}}, {"empty_steps", {1}}};
  const auto batch = make_seeing("RememberColor3-VLA-v0", options);
  const auto places = [&](int color) {
    std::vector<int> result;
    for (int i = 0; i < 64; ++i) {
      const auto tokens = tokens_of(*batch, i);
      const auto of_color = [&](const auto& token) {
        return is_seen(token) && color_of(token) == color;
      };
      result.push_back(static_cast<int>(std::ranges::find_if(tokens, of_color) - tokens.begin()));
    }
    return result;
  };
  const std::vector<int> cue = places(0);
  test::step(*batch, Policy::kZero);
  test::step(*batch, Policy::kZero);
  const std::vector<int> later = places(0);
  // Every place occurs in both, and the one says nothing about the other.
  for (const auto& all : {cue, later}) {
    for (int place = 0; place < 3; ++place) CHECK(std::ranges::count(all, place) > 8);
  }
  int same = 0;
  for (std::size_t i = 0; i < 64; ++i) same += cue[i] == later[i] ? 1 : 0;
  CHECK(same > 8);
  CHECK(same < 38);
  // While all stay in view, they keep their places.
  for (int t = 0; t < 5; ++t) {
    test::step(*batch, Policy::kRandom);
    CHECK(places(0) == later);
  }
}

TEST_CASE("What a cup stands over is not seen", "[objects]") {
  for (const char* id : {"ShellGameTouch-VLA-v0", "ShellGamePush-VLA-v0", "ShellGamePick-VLA-v0",
                         "ShellGameShuffleTouch-VLA-v0"}) {
    INFO(id);
    const auto batch = make_seeing(id);
    const auto seen_kinds = [&] {
      std::multiset<std::string_view> kinds;
      for (const auto& token : tokens_of(*batch)) {
        if (!is_seen(token)) continue;
        const int kind = one_hot(token, Layout::kKind, kObjectKindNames.size());
        kinds.insert(kObjectKindNames[static_cast<std::size_t>(kind)]);
      }
      return kinds;
    };
    CHECK(seen_kinds() == std::multiset<std::string_view>{"ball"});
    while (batch->state().status_of(0, 0) == PropStatus::kHidden) test::step(*batch, Policy::kZero);
    CHECK(seen_kinds() == std::multiset<std::string_view>{"cup", "cup", "cup"});
  }
}

TEST_CASE("A cup that is lifted off shows the ball that it leaves behind", "[objects]") {
  MakeOptions options;
  options.num_envs = 20;
  options.terminate_on_success = false;
  options.rules = GENERATE(Rules::kOriginal, Rules::kReference);
  const auto batch = make_seeing("ShellGamePick-VLA-v0", options);
  int shown = 0;
  for (int t = 0; t < 30; ++t) {
    test::step(*batch, Policy::kOracle);
    for (int i = 0; i < batch->num_envs(); ++i) {
      const auto tokens = tokens_of(*batch, i);
      shown += std::ranges::count_if(tokens, is_seen) == 4 ? 1 : 0;
    }
  }
  // Under the reference's rules the ball is lifted in its cup.
  if (options.rules == Rules::kOriginal) {
    CHECK(shown > 20);
  } else {
    CHECK(shown == 0);
  }
}

TEST_CASE("Lamps and buttons show their state", "[objects]") {
  // Pressed as far as it goes, which the oracle does, a button shows 1.
  MakeOptions options;
  options.constants = {{"BUTTON_CAP_TRAVEL", GENERATE(0.007, 0.014, 0.02)}};
  const auto batch = make_seeing("BlinkCountButtonPressEasy-VLA-v0", options);
  std::set<float> lamps;
  float pressed = 0;
  for (int t = 0; t < batch->info().horizon - 1; ++t) {
    for (const auto& token : tokens_of(*batch)) {
      const int kind = one_hot(token, Layout::kKind, kObjectKindNames.size());
      const float state = token[Layout::kState];
      if (kObjectKindNames[static_cast<std::size_t>(kind)] == "lamp") lamps.insert(state);
      if (kObjectKindNames[static_cast<std::size_t>(kind)] == "button") {
        pressed = std::max(pressed, state);
      }
    }
    if (batch->state().finished[0] != 0) break;
    test::step(*batch, Policy::kOracle);
  }
  CHECK(lamps == std::set<float>{0, 1});
  CHECK(pressed == Approx(1));
}

// The first part of a row whose values are beyond its range; empty: none.
std::string beyond_range(const Batch& batch) {
  const float* value = batch.outputs().observation.data();
  for (int i = 0; i < batch.num_envs(); ++i) {
    for (const RangedField& part : Queries(batch).ranged_fields()) {
      for (int k = 0; k < part.field.width; ++k, ++value) {
        const auto number = static_cast<double>(*value);
        if (!(number >= part.low && number <= part.high)) return part.field.name;
      }
    }
  }
  return "";
}

TEST_CASE("Rows are described part by part, and lie in the ranges", "[objects]") {
  const Policy policy = GENERATE(Policy::kRandom, Policy::kOracle);
  for (const std::string& id : test::implemented_ids()) {
    MakeOptions options;
    options.num_envs = 2;
    options.observe_time = true;
    const auto batch = make_seeing(id, options);
    int width = 0;
    for (const Field& field : Queries(*batch).state_fields()) width += field.width;
    INFO(id);
    CHECK(width == batch->state_dim());
    CHECK(batch->outputs().observation.size() == 2 * static_cast<std::size_t>(width));
    CHECK(Queries(*batch).ranged_fields().size() == Queries(*batch).state_fields().size());
    CHECK(!tokens_of(*batch).empty());
    // Numbers that networks like, while nothing is thrown about.
    for (const float value : batch->outputs().observation) CHECK(std::abs(value) < 4);
    for (int t = 0; t < 60; ++t) {
      REQUIRE(beyond_range(*batch) == "");
      test::step(*batch, policy);
    }
  }
}

TEST_CASE("What is far off or fast is cut off at the ends of the ranges", "[objects]") {
  MakeOptions options;
  options.obs_mode = ObsMode::kObjects;
  const auto batch = make_running("RememberColor3-VLA-v0", options);
  batch->state().prop_pos.row(0)[0] = 1e6;
  batch->state().prop_pos.row(0)[1] = -1e6;
  batch->state().qvel.row(0)[0] = 1e6;
  Snapshotter(*batch).restore(Snapshotter(*batch).save());  // observes
  CHECK(beyond_range(*batch) == "");
  CHECK(std::ranges::max(batch->outputs().observation) == static_cast<float>(ObjectTokens::kMax));
}

TEST_CASE("Restored environments observe what they were saved with", "[objects][snapshot]") {
  MakeOptions options;
  options.num_envs = 4;
  const auto batch = make_seeing("FindImposterColor5-VLA-v0", options);
  for (int t = 0; t < 12; ++t) test::step(*batch, Policy::kRandom);
  const auto copy = make_seeing("FindImposterColor5-VLA-v0", options);
  Snapshotter(*copy).restore(Snapshotter(*batch).save());
  for (int t = 0; t < 5; ++t) {
    CHECK(std::ranges::equal(batch->outputs().observation, copy->outputs().observation));
    test::step(*batch, Policy::kRandom);
    test::step(*copy, Policy::kRandom);
  }
}

// Such a snapshot knows no order of tokens.
TEST_CASE("What a batch without objects has saved is observed as ever", "[objects][snapshot]") {
  MakeOptions options;
  options.pins = {{"target", {2}}, {"cue_steps", {2}}, {"empty_steps", {2}}};
  const char* id = "RememberColor9-VLA-v0";
  const auto blind = make_env(id, options);
  const auto seeing = make_seeing(id, options);
  for (int t = 0; t < 5; ++t) test::step(*seeing, Policy::kZero);  // all tokens are filled
  blind->reset();
  for (int t = 0; t < 6; ++t) {
    Snapshotter(*seeing).restore(Snapshotter(*blind).save());
    const auto tokens = tokens_of(*seeing);
    CHECK(std::ranges::count_if(tokens, is_seen) == (t < 2 ? 1 : t < 4 ? 0 : 9));
    const auto filled = [](const auto& token) {
      return std::ranges::any_of(token, [](float value) { return value != 0; });
    };
    CHECK(std::ranges::count_if(tokens, filled) == std::ranges::count_if(tokens, is_seen));
    test::step(*blind, Policy::kZero);
  }
}

}  // namespace
}  // namespace engram
