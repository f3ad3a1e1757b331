// The content of the cue must not be in any later observation of the objects modes, nor in
// what else a policy is given.
#include <algorithm>
#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <cstdio>
#include <set>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "core/batch/snapshot.h"
#include "tasks/family_samples.h"
#include "tests/tasks/leak_check.h"

namespace engram {
namespace {

constexpr std::uint64_t kEpisodes = 4;  // of long tasks: one
constexpr int kHiding = 107;            // ids that hide something behind a cue

enum class Drawing {
  kExtremes,  // two values of the hidden draw, as different as possible
  kDefault,   // one batch draws as ever, the other has a value
};

std::unique_ptr<Batch> make_seeing(const std::string& id, std::uint64_t seed,
                                   const std::vector<Pin>& pins,
                                   Physics physics = Physics::kEngram) {
  BatchOptions options{.seed = seed,
                       .threads = 1,
                       .obs_mode = ObsMode::kObjects,
                       .observe_time = true,
                       .auto_reset = AutoReset::kOff};
  options.reward_mode = RewardMode::kSparse;  // dense ones measure the way to the hidden goal
  options.pins = pins;
  options.physics = physics;
  return test::make_running(id, options);
}

// Two batches of one environment with the same seed, and something else to be remembered.
struct Pair {
  std::unique_ptr<Batch> one;
  std::unique_ptr<Batch> other;
};

Pair make_pair(const std::string& id, std::uint64_t seed, const RandomVariable& draw,
               Drawing drawing, Physics physics = Physics::kEngram) {
  const auto pinned = [&draw](bool other) {
    return std::vector<Pin>{{draw.name, test::hidden_values(draw, other)}};
  };
  if (drawing == Drawing::kExtremes) {
    return {make_seeing(id, seed, pinned(false), physics),
            make_seeing(id, seed, pinned(true), physics)};
  }
  return {make_seeing(id, seed, {}, physics),
          make_seeing(id, seed, pinned(seed % 2 == 1), physics)};
}

struct Count {
  int tasks = 0;
  int steps = 0;                  // that were compared
  int shown = 0;                  // steps in which the cue could be seen in the observation
  std::set<std::string> leaking;  // outputs that differ where nothing may differ
  std::set<std::string> closed;   // the others that differ there
};

void compare_outputs(const Batch& one, const Batch& other, Count& count) {
  ++count.steps;
  for (const std::string& name : test::differing_outputs(one, other)) {
    (test::is_closed(one, name) ? count.closed : count.leaking).insert(name);
  }
}

// Until the robot has answered, observations, infos and rewards differ in the moments that show the
// cue alone. change: is applied to `one` before it is compared.
template <class Change>
void compare(const Pair& pair, Policy policy, Count& count, Change&& change) {
  Batch& one = *pair.one;
  Batch& other = *pair.other;
  test::play_unanswered(one, other, policy, [&](bool shown) {
    if (shown) {
      count.shown +=
          std::ranges::equal(one.outputs().observation, other.outputs().observation) ? 0 : 1;
    } else {
      change(one);
      compare_outputs(one, other, count);
    }
  });
}

void compare(const Pair& pair, Policy policy, Count& count) {
  compare(pair, policy, count, [](Batch& /*one*/) {});
}

// Checks the ids that hide something behind a cue. The others have tests of their own below.
Count check(const std::vector<std::string>& ids, Policy policy, Drawing drawing,
            Physics physics = Physics::kEngram, std::uint64_t episodes = kEpisodes) {
  Count count;
  for (const std::string& id : ids) {
    const TaskInfo info = make_task(id)->info();
    const std::optional<RandomVariable> draw = test::draw_named(info, info.hidden_variable);
    if (!draw) continue;
    ++count.tasks;
    const int before = count.shown;
    for (std::uint64_t seed = 0; seed < (info.horizon > 300 ? 1 : episodes); ++seed) {
      INFO(id << ", seed " << seed << ", " << name_of(policy));
      compare(make_pair(id, seed, *draw, drawing, physics), policy, count);
      REQUIRE(count.leaking == std::set<std::string>{});
    }
    INFO(id);
    const bool at_a_set_time = Queries(*make_seeing(id, 0, {})).cue_end(0) < info.horizon;
    // What was drawn may be what the other has.
    if (at_a_set_time && drawing == Drawing::kExtremes) CHECK(count.shown > before);
  }
  return count;
}

Count check_all(Policy policy, Drawing drawing, Physics physics = Physics::kEngram) {
  Count count = check(test::implemented_ids(), policy, drawing, physics);
  CHECK(count.tasks == kHiding);
  CHECK(count.steps > 15000);
  CHECK(count.shown > 3500);
  return count;
}

TEST_CASE("Objects and infos of short episodes reveal nothing after the cue", "[objects][leak]") {
  const Physics physics = GENERATE(Physics::kEngram, Physics::kMujoco);
  const std::uint64_t episodes = physics == Physics::kEngram ? kEpisodes : 1;  // MuJoCo's is slow
  const Count count = check(short_ids(), Policy::kSweep, Drawing::kExtremes, physics, episodes);
  CHECK(count.tasks > 25);
  CHECK(count.steps > 500);
  CHECK(count.shown > 100);
  CHECK(count.closed.contains("oracle_info"));
}

TEST_CASE("Objects and infos reveal nothing after the cue", "[objects][leak][long]") {
  const Policy policy = GENERATE(Policy::kZero, Policy::kRandom, Policy::kSweep, Policy::kBlind);
  const Drawing drawing = GENERATE(Drawing::kExtremes, Drawing::kDefault);
  const Count count = check_all(policy, drawing);
  std::printf("objects, %s, %s: %d tasks, %d steps compared, %d in which the cue shows\n",
              name_of(policy), drawing == Drawing::kExtremes ? "pinned" : "drawn", count.tasks,
              count.steps, count.shown);
}

TEST_CASE("Objects and infos reveal nothing after the cue under MuJoCo's physics",
          "[objects][leak][mujoco][long]") {
  const Policy policy = GENERATE(Policy::kZero, Policy::kRandom);
  const Count count = check_all(policy, Drawing::kExtremes, Physics::kMujoco);
  std::printf("objects under mujoco, %s: %d tasks, %d steps compared, %d in which the cue shows\n",
              name_of(policy), count.tasks, count.steps, count.shown);
}

TEST_CASE("Every info that is closed to policies reveals something", "[objects][leak][long]") {
  Count all;
  for (const Policy policy : {Policy::kRandom, Policy::kSweep, Policy::kBlind}) {
    all.closed.merge(check_all(policy, Drawing::kExtremes).closed);
  }
  std::set<std::string> closed;
  for (const std::string& id : test::implemented_ids()) {
    const auto batch = make_seeing(id, 0, {});
    for (std::size_t i = 0; i < test::columns_of(*batch).size(); ++i) {
      const Field& field = *batch->output(test::columns_of(*batch)[i].field->name).field;
      if (field.privileged) closed.insert(field.name);
    }
  }
  closed.erase("reward_dict");  // of the dense rewards, which are not looked at here
  CHECK(closed.size() == 20);
  CHECK(all.closed == closed);
}

TEST_CASE("The ids that hide nothing behind a cue are those with tests of their own",
          "[objects][leak]") {
  const auto of_family = [](std::string_view name) {
    return std::ranges::count_if(registry(), [name](const RegistryEntry& entry) {
      return std::string_view(entry.id).starts_with(name);
    });
  };
  CHECK(kHiding + of_family("Rotate") + of_family("TakeItBack") + of_family("Intercept") ==
        std::ssize(registry()));
}

TEST_CASE("A token or an info that revealed the hidden quantity would be noticed",
          "[objects][leak]") {
  const std::string id = "RememberColor3-VLA-v0";
  const RandomVariable draw = *test::draw_named(make_task(id)->info(), "target");
  const auto leaking = [&](auto&& change) {
    Count count;
    compare(make_pair(id, 0, draw, Drawing::kExtremes), Policy::kRandom, count, change);
    CHECK(count.steps > 5);
    return count.leaking;
  };
  const auto hidden = [](const Batch& batch) {
    return static_cast<float>(*test::row<std::int32_t>(batch.output("oracle_info"), 0));
  };
  CHECK(leaking([](Batch& /*one*/) {}) == std::set<std::string>{});
  CHECK(leaking([&](Batch& one) {
          auto* row = reinterpret_cast<float*>(one.output("observation").row(0));
          row[one.state_dim() - 1] = hidden(one) + 0.25F;
        }) == std::set<std::string>{"observation"});
  CHECK(leaking([&](Batch& one) {
          *reinterpret_cast<float*>(one.output("reward").row(0)) = hidden(one) + 0.25F;
        }) == std::set<std::string>{"reward"});
}

// So what is said of infos and rewards here holds of all of them.
TEST_CASE("Infos and rewards are the same whatever is observed", "[objects][leak]") {
  for (const std::string& id : test::implemented_ids()) {
    BatchOptions options{.seed = 5};
    options.images.width = options.images.height = 8;
    const auto first = make(id, options);
    first->reset();
    for (const ObsMode mode : {ObsMode::kNone, ObsMode::kRgb, ObsMode::kObjects}) {
      INFO(id << ", " << name_of(mode));
      options.obs_mode = mode;
      const auto batch = make(id, options);
      batch->reset();
      first->reset({.mask = {}, .seeds = std::array<std::uint64_t, 1>{5}});
      for (int t = 0; t < 8; ++t) {
        std::vector<std::string> names = test::differing_outputs(*first, *batch);
        std::erase(names, "observation");
        REQUIRE(names == std::vector<std::string>{});
        const std::vector<float> actions = test::act(*first, Policy::kRandom);
        first->step(actions);
        batch->step(actions);
      }
    }
  }
}

// --- tasks without a hidden draw behind a cue ---

TEST_CASE("Nothing of Intercept is ever hidden", "[objects][leak]") {
  for (const std::string& id : test::implemented_ids()) {
    if (!id.starts_with("Intercept")) continue;
    INFO(id);
    const auto batch = make_seeing(id, 1, {});
    const std::size_t objects = [&batch] {
      std::size_t count = 0;
      for (const Field& field : Queries(*batch).state_fields())
        count += field.name.ends_with("_seen") ? 1 : 0;
      return count;
    }();
    for (int t = 0; t < batch->info().horizon - 1 && batch->state().finished[0] == 0; ++t) {
      const auto seen = *test::row<std::uint64_t>(test::memory_of(*batch).find("tokens_seen"), 0);
      REQUIRE(static_cast<std::size_t>(std::popcount(seen)) == objects);
      test::step(*batch, Policy::kOracle);
    }
  }
}

// The angle is a cue that policies may see; everything else is the same.
TEST_CASE("Objects of Rotate have the angle in task_cue alone", "[objects][leak]") {
  const Policy policy = GENERATE(Policy::kZero, Policy::kRandom);
  for (const std::string& id : test::implemented_ids()) {
    if (!id.starts_with("Rotate")) continue;
    const RandomVariable draw = *test::draw_named(make_task(id)->info(), "target_angle");
    const auto [one, other] = make_pair(id, 3, draw, Drawing::kExtremes);
    for (int t = 0; t < 40; ++t) {
      std::size_t at = 0;
      for (const Field& field : Queries(*one).state_fields()) {
        const auto begin = static_cast<std::ptrdiff_t>(at);
        at += static_cast<std::size_t>(field.width);
        const bool same =
            std::equal(one->outputs().observation.begin() + begin,
                       one->outputs().observation.begin() + static_cast<std::ptrdiff_t>(at),
                       other->outputs().observation.begin() + begin);
        REQUIRE(same == (field.name != "task_cue"));
      }
      const std::vector<float> actions = test::act(*one, policy);
      one->step(actions);
      other->step(actions);
      // An RL episode ends at its success.
      if ((one->state().finished[0] | other->state().finished[0]) != 0) break;
    }
  }
}

// With another start in the environment's memory, and the same robot, all observations are the
// same.
TEST_CASE("Objects of TakeItBack do not reveal the start once the cube is on its target",
          "[objects][leak]") {
  const std::string id = GENERATE(as<std::string>{}, "TakeItBack-VLA-v0", "TakeItBack-v0");
  const Policy policy = GENERATE(Policy::kZero, Policy::kRandom, Policy::kBlind);
  int compared = 0;
  for (std::uint64_t seed = 0; seed < kEpisodes; ++seed) {
    const auto one = make_seeing(id, seed, {});
    const auto other = make_seeing(id, seed, {});
    while (*test::row<std::uint8_t>(one->output("goal_reached_status"), 0) == 0) {
      test::step(*one, Policy::kOracle);
    }
    Snapshotter(*other).restore(Snapshotter(*one).save());
    auto* start = reinterpret_cast<double*>(test::memory_of(*other).find("initial").row(0));
    start[0] += 1;  // where the cube never comes
    for (int t = 0; t < 15; ++t, ++compared) {
      // An answer tells whether it was right, and success, which may come first, where the start
      // is.
      if (test::has_answered(*one) || test::has_answered(*other) || one->outputs().success[0] != 0)
        break;
      REQUIRE(test::leaking_outputs(*one, *other) == std::vector<std::string>{});
      const std::vector<float> actions = test::act(*one, policy);
      one->step(actions);
      other->step(actions);
    }
  }
  CHECK(compared > 15);
}

// --- images ---

// Pixels of the sensors' images that change when props are taken out of the scene. bare: a batch
// of the same task, for that; images: of both.
int pixels_of(Batch& batch, Batch& bare, test::ImagePair& images, std::uint64_t props) {
  Snapshotter(bare).restore(Snapshotter(batch).save());
  for (int prop = 0; prop < batch.state().num_props; ++prop) {
    if ((props >> prop & 1) == 0) continue;
    bare.state().prop_status.row(0)[prop] = static_cast<std::uint8_t>(PropStatus::kHidden);
  }
  return images.differing_pixels("base_camera") + images.differing_pixels("hand_camera");
}

// Returns how many tokens were ever filled.
int check_tokens(const std::vector<std::string>& ids) {
  int tokens = 0;
  for (const std::string& id : ids) {
    const BatchOptions options{.threads = 1, .obs_mode = ObsMode::kObjects};
    const auto batch = make(id, options);
    const auto bare = make(id, options);
    batch->reset();
    bare->reset();
    test::ImagePair images(*batch, *bare);
    // Parts of other props have no token.
    std::uint64_t objects = 0;
    const std::vector<ObjectDescriptor> looks = make_task(id)->object_descriptors();
    for (std::size_t prop = 0; prop < looks.size(); ++prop) {
      objects |= std::uint64_t{looks[prop].kind != ObjectKind::kPart} << prop;
    }
    std::uint64_t ever_seen = 0;
    std::uint64_t in_images = 0;
    for (int t = 0; t < 90; ++t) {
      const auto seen = *test::row<std::uint64_t>(test::memory_of(*batch).find("tokens_seen"), 0);
      ever_seen |= seen;
      if (t % 3 == 0) {
        INFO(id << ", step " << t << ", seen " << seen);
        REQUIRE(pixels_of(*batch, *bare, images, objects & ~seen) == 0);
        for (std::uint64_t left = seen & ~in_images; left != 0; left &= left - 1) {
          const std::uint64_t prop = left & (~left + 1);
          if (pixels_of(*batch, *bare, images, prop) > 0) in_images |= prop;
        }
      }
      test::step(*batch, Policy::kOracle);
    }
    INFO(id);
    CHECK(in_images == ever_seen);
    tokens += std::popcount(ever_seen);
  }
  return tokens;
}

TEST_CASE("Tokens are filled for what the sensors' images of short episodes show",
          "[objects][render]") {
  CHECK(check_tokens(short_ids()) > 100);
}

TEST_CASE("Tokens are filled for what the sensors' images show, and for nothing else",
          "[objects][render][long]") {
  CHECK(check_tokens(test::implemented_ids()) > 500);
}

}  // namespace
}  // namespace engram
