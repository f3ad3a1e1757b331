#include "core/batch/snapshot.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "core/base/checksum.h"
#include "core/base/error.h"
#include "core/math/random.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::Bytes, test::env_bytes, test::make_env, test::make_running;

constexpr const char* kId = "RememberColor9-VLA-v0";

// The oracle's way to the target, then down onto it.
void press(Batch& batch) {
  std::vector<float> actions = test::act(batch, Policy::kOracle);
  for (int i = 0; i < batch.num_envs(); ++i) {
    if (batch.state().elapsed[i] >= 18) actions[static_cast<std::size_t>(7 * i + 2)] = -0.5F;
  }
  batch.step(actions);
}

// What one environment shows and remembers over the next steps.
std::vector<Bytes> future(Batch& batch, int index, int steps = 45) {
  std::vector<Bytes> history;
  for (int i = 0; i < steps; ++i) {
    press(batch);
    history.push_back(env_bytes(batch, index));
  }
  return history;
}

BatchOptions batch_of(int num_envs, std::uint64_t seed = 0) {
  BatchOptions options{.num_envs = num_envs, .seed = seed};
  return options;
}

TEST_CASE("An environment goes on bit for bit after it was restored", "[snapshot]") {
  RandomStream random(1, 0, 0);
  for (int round = 0; round < 8; ++round) {
    const auto batch = make_running(kId, batch_of(3, static_cast<std::uint64_t>(10 * round)));
    const int steps = random.integer(0, 40);
    for (int i = 0; i < steps; ++i) press(*batch);
    const int index = random.integer(0, 2);
    const std::vector<std::byte> saved = Snapshotter(*batch).save(index);
    const Bytes now = env_bytes(*batch, index);
    const std::vector<Bytes> expected = future(*batch, index);

    // Into the same slot, another slot, and a batch of another size and seed.
    Snapshotter(*batch).restore(index, saved);
    CHECK(env_bytes(*batch, index) == now);
    CHECK((future(*batch, index) == expected));
    Snapshotter(*batch).restore((index + 1) % 3, saved);
    CHECK((future(*batch, (index + 1) % 3) == expected));
    const auto other = make_running(kId, batch_of(5, 999));
    for (int i = 0; i < round; ++i) press(*other);
    Snapshotter(*other).restore(4, saved);
    CHECK((future(*other, 4) == expected));
  }
}

TEST_CASE("A snapshot in the middle of a contact goes on bit for bit", "[snapshot]") {
  BatchOptions options = batch_of(1, 3);
  options.sleep = GENERATE(true, false);
  const auto batch = make_running(kId, options);
  const auto in_contact = [&] {
    const double* force = batch->state().finger_force.row(0);
    return std::any_of(force, force + 54, [](double v) { return v != 0; });
  };
  int contacts = 0;
  for (int i = 0; i < 24; ++i) {
    press(*batch);
    if (!in_contact()) continue;
    ++contacts;
    const std::vector<std::byte> saved = Snapshotter(*batch).save();
    const std::vector<Bytes> expected = future(*batch, 0, 10);
    const auto fresh = make_env(kId, options);
    Snapshotter(*fresh).restore(saved);
    CHECK((future(*fresh, 0, 10) == expected));
    Snapshotter(*batch).restore(saved);
  }
  CHECK(contacts >= 2);
}

// Under way, in flight, in a grasp: whatever the oracle is doing by then.
TEST_CASE("Every task goes on bit for bit from the middle of an episode", "[snapshot]") {
  const auto play = [](Batch& batch, int steps) {
    std::vector<Bytes> history;
    for (int i = 0; i < steps; ++i) {
      test::step(batch, Policy::kOracle);
      history.push_back(test::batch_bytes(batch));
    }
    return history;
  };
  for (const std::string& id : test::implemented_ids()) {
    const auto batch = make_running(id, batch_of(2, 7));
    for (const int steps : {2, 10, 10}) {
      play(*batch, steps);
      const std::vector<std::byte> saved = Snapshotter(*batch).save();
      const std::vector<Bytes> expected = play(*batch, 6);
      const auto fresh = make_env(id, batch_of(2, 50));
      Snapshotter(*fresh).restore(saved);
      INFO(id);
      CHECK((play(*fresh, 6) == expected));
    }
  }
}

TEST_CASE("A reset leaves nothing of the episode before", "[reset]") {
  for (const std::string& id : test::implemented_ids()) {
    const auto fresh = make_running(id, batch_of(2, 30));
    const auto used = make_running(id, batch_of(2, 7));
    for (int i = 0; i < 22; ++i) test::step(*used, Policy::kOracle);
    const Bytes other = env_bytes(*used, 0);
    const std::vector<std::uint8_t> mask = {0, 1};
    const std::vector<std::uint64_t> seeds = {30, 31};
    used->reset({.mask = mask, .seeds = seeds});
    INFO(id);
    CHECK((env_bytes(*used, 1) == env_bytes(*fresh, 1)));
    CHECK((env_bytes(*used, 0) == other));
  }
}

TEST_CASE("A whole batch is restored into a fresh one, pins included", "[snapshot]") {
  BatchOptions options = batch_of(4);
  options.pins = {{"target", {6}}};
  const auto batch = make_running(kId, options);
  for (int i = 0; i < 20; ++i) press(*batch);
  const std::vector<std::byte> saved = Snapshotter(*batch).save();
  CHECK(Snapshotter(*batch).save() == saved);
  const auto fresh = make_env(kId, batch_of(4, 50));  // never reset, without pins
  Snapshotter(*fresh).restore(saved);
  for (int i = 0; i < 40; ++i) {  // over an automatic reset
    press(*batch);
    press(*fresh);
    REQUIRE(test::batch_bytes(*fresh) == test::batch_bytes(*batch));
  }
  CHECK(*test::row<std::int32_t>(test::memory_of(*fresh).find("target"), 0) == 6);
  CHECK(fresh->state().episode[0] > 0);
}

TEST_CASE("Restoring one environment leaves its neighbours alone", "[snapshot]") {
  const auto batch = make_running(kId, batch_of(3));
  const std::vector<std::byte> saved = Snapshotter(*batch).save(0);
  for (int i = 0; i < 12; ++i) press(*batch);
  const Bytes first = env_bytes(*batch, 0);
  const Bytes last = env_bytes(*batch, 2);
  Snapshotter(*batch).restore(1, saved);
  CHECK(env_bytes(*batch, 0) == first);
  CHECK(env_bytes(*batch, 2) == last);
  CHECK(batch->state().elapsed[1] == 0);
}

TEST_CASE("Snapshots that are damaged or foreign are refused and change nothing", "[snapshot]") {
  const auto batch = make_running(kId, batch_of(2));
  for (int i = 0; i < 5; ++i) press(*batch);
  const std::vector<std::byte> good = Snapshotter(*batch).save();
  const std::vector<std::byte> single = Snapshotter(*batch).save(0);
  press(*batch);
  const Bytes before = test::batch_bytes(*batch);
  const auto refuse = [&](const std::vector<std::byte>& bytes, const char* why) {
    CHECK_THROWS_WITH(Snapshotter(*batch).restore(bytes),
                      Catch::StartsWith("snapshot refused: ") && Catch::Contains(why));
    CHECK(test::batch_bytes(*batch) == before);
  };

  constexpr std::size_t kHeader = 48;  // and the label behind it
  const std::string label =
      std::string(kId) + ", pd_ee_delta_pose, rules=reference, success_in_cue=0, strict=0";
  RandomStream random(5, 0, 0);
  for (int i = 0; i < 500; ++i) {  // any damaged byte of the content
    std::vector<std::byte> bad = good;
    const int at =
        random.integer(static_cast<int>(kHeader + label.size()), static_cast<int>(bad.size()) - 1);
    bad[static_cast<std::size_t>(at)] ^=
        std::byte{static_cast<unsigned char>(random.integer(1, 255))};
    refuse(bad, "damaged");
  }
  for (std::size_t at = 0; at < kHeader + label.size(); ++at) {  // any bit of header and label
    for (int bit = 0; bit < 8; ++bit) {
      std::vector<std::byte> bad = good;
      bad[at] ^= std::byte{static_cast<unsigned char>(1 << bit)};
      refuse(bad, at < 8 ? "not a snapshot" : at < 12 ? "version" : "");
    }
  }
  for (std::size_t size = 0; size < good.size(); ++size) {  // cut off anywhere
    refuse({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)},
           size < kHeader ? "too short" : "needed by its header");
  }
  std::vector<std::byte> longer = good;
  longer.push_back(std::byte{0});
  refuse(longer, "needed by its header");
  std::vector<std::byte> older = good;
  older[8] = std::byte{1};
  refuse(older, "version 1 given, 7 needed");
  refuse(single, "1 environments given, 2 needed");
  CHECK_THROWS_WITH(Snapshotter(*batch).restore(0, good),
                    Catch::Contains("2 environments given, 1 needed"));

  const auto foreign = make_running("RememberColor5-VLA-v0", batch_of(2));
  refuse(Snapshotter(*foreign).save(),
         "it is of RememberColor5-VLA-v0, pd_ee_delta_pose, rules=reference, success_in_cue=0, "
         "strict=0; "
         "this batch is of RememberColor9-VLA-v0, pd_ee_delta_pose, rules=reference, "
         "success_in_cue=0, strict=0");
  // Equal columns, but another task.
  const auto lengthy = make_running("RememberColor9-Long-VLA-v0", batch_of(2));
  refuse(Snapshotter(*lengthy).save(), "it is of RememberColor9-Long-VLA-v0, ");
  BatchOptions other_mode = batch_of(2);
  other_mode.control_mode = ControlMode::kPdEePose;  // the same columns here too
  const auto mode = make_running(kId, other_mode);
  refuse(Snapshotter(*mode).save(),
         "it is of RememberColor9-VLA-v0, pd_ee_pose, rules=reference, ");
  CHECK(test::batch_bytes(*batch) == before);
  Snapshotter(*batch).restore(good);  // the good one still is
  CHECK(Snapshotter(*batch).save() == good);
}

// --- made-up bytes, with a checksum that fits ---

// Where the first environment's columns begin.
std::size_t rows_of(const std::vector<std::byte>& snapshot) {
  constexpr std::size_t kHeader = 48;
  std::uint64_t label_bytes = 0;
  std::memcpy(&label_bytes, snapshot.data() + 40, sizeof label_bytes);
  return kHeader + label_bytes;
}

// Where a column of the memory or, at a snapshot's end, of the outputs lies.
std::size_t place_of(const Batch& batch, const std::vector<std::byte>& snapshot,
                     const char* column) {
  const bool remembered = test::memory_of(batch).find(column).field != nullptr;
  const ColumnStore& store = remembered ? test::memory_of(batch) : test::columns_of(batch);
  std::size_t at = remembered ? rows_of(snapshot) : snapshot.size() - store.row_bytes();
  for (std::size_t i = 0; store[i].field->name != column; ++i) {
    const Field& field = *store[i].field;
    at += size_of(field.dtype) * static_cast<std::size_t>(field.width);
  }
  return at;
}

template <class T>
std::vector<std::byte> made_up(std::vector<std::byte> bytes, std::size_t at, T value) {
  constexpr std::size_t kChecksumAt = 16;
  std::memcpy(bytes.data() + at, &value, sizeof value);
  std::memset(bytes.data() + kChecksumAt, 0, sizeof(std::uint64_t));
  const std::uint64_t sum = checksum(std::span<const std::byte>(bytes));
  std::memcpy(bytes.data() + kChecksumAt, &sum, sizeof sum);
  return bytes;
}

TEST_CASE("Snapshots of what no episode can have are refused", "[snapshot]") {
  const auto batch = make_running(kId, batch_of(1));
  const std::vector<std::byte> good = Snapshotter(*batch).save();
  const Bytes before = test::batch_bytes(*batch);
  const auto position = [&](const char* column) { return place_of(*batch, good, column); };
  const auto with = [&good](std::size_t at, auto value) { return made_up(good, at, value); };
  const auto refuse = [&](const std::vector<std::byte>& bytes, const char* why) {
    CHECK_THROWS_WITH(Snapshotter(*batch).restore(bytes), Catch::Contains(why));
    CHECK_THROWS_WITH(Snapshotter(*batch).restore(0, bytes), Catch::Contains(why));
    CHECK((test::batch_bytes(*batch) == before));
  };
  for (const std::int32_t target : {-1, 9, 1'000'000, INT32_MIN, INT32_MAX}) {
    refuse(with(position("target"), target), "'target' has a value that no episode");
  }
  refuse(with(position("elapsed"), std::int32_t{-1}), "'elapsed'");
  refuse(with(position("elapsed"), batch->info().horizon + 1), "'elapsed'");
  refuse(with(position("finished"), std::uint8_t{2}), "'finished'");
  refuse(with(position("prop_status"), std::uint8_t{3}), "'prop_status'");
  const std::size_t pins = rows_of(good) + test::memory_of(*batch).row_bytes();
  refuse(with(pins, ~std::uint64_t{0}), "snapshot refused");
  Snapshotter(*batch).restore(
      with(position("target"), std::int32_t{8}));  // what one can have is taken
  CHECK(*test::row<std::int32_t>(test::memory_of(*batch).find("target"), 0) == 8);
}

// A further bit would be that of a checkpoint behind the last one.
TEST_CASE("Snapshots with visits of checkpoints that there are not are refused", "[snapshot]") {
  for (const char* id : {"TraceShapeEasy-VLA-v0", "TraceShapeSeqEasy-VLA-v0"}) {
    const auto batch = make_running(id, batch_of(1));
    const std::vector<std::byte> good = Snapshotter(*batch).save();
    for (const char* column : {"visited", "guess_visited"}) {
      for (const std::int32_t visits : {-1, INT32_MAX}) {
        INFO(id << " " << column << " " << visits);
        CHECK_THROWS_WITH(
            Snapshotter(*batch).restore(made_up(good, place_of(*batch, good, column), visits)),
            Catch::Contains(std::string("'") + column + "' has a value that no"));
      }
    }
    CHECK(Snapshotter(*batch).save() == good);
  }
}

// Their beginnings would be read behind the last one.
TEST_CASE("Snapshots of more blinks than there can be are refused", "[snapshot]") {
  const auto batch = make_running("BlinkCountButtonPressEasy-VLA-v0", batch_of(1));
  const std::vector<std::byte> good = Snapshotter(*batch).save();
  const std::size_t target = place_of(*batch, good, "target_blinks");
  for (const std::int32_t count : {-1, 1000, INT32_MAX}) {
    CHECK_THROWS_WITH(Snapshotter(*batch).restore(made_up(good, target, count)),
                      Catch::Contains("'target_blinks' has a value that no"));
  }
  CHECK(Snapshotter(*batch).save() == good);
}

TEST_CASE("A snapshot goes only into batches of the same task options", "[snapshot]") {
  constexpr const char* kRecall = "SeqOfColors3-VLA-v0";
  BatchOptions options = batch_of(1);
  options.task_options = {{"touch_radius", 0.031}};
  const auto narrow = make_running(kRecall, options);
  const auto usual = make_running(kRecall, batch_of(1));
  const Bytes before = env_bytes(*usual, 0);
  CHECK_THROWS_WITH(Snapshotter(*usual).restore(Snapshotter(*narrow).save()),
                    Catch::Contains("it is of SeqOfColors3-VLA-v0, pd_ee_delta_pose, "
                                    "rules=reference, touch_radius=0.031, ") &&
                        Catch::Contains("; this batch is of SeqOfColors3-VLA-v0, pd_ee_delta_pose, "
                                        "rules=reference, touch_radius=0.05, "));
  CHECK((env_bytes(*usual, 0) == before));
  const auto same = make_env(kRecall, options);
  Snapshotter(*same).restore(Snapshotter(*narrow).save());
  CHECK((env_bytes(*same, 0) == env_bytes(*narrow, 0)));
}

TEST_CASE("What is observed of a snapshot is up to the batch it goes into", "[snapshot]") {
  for (const std::string& id : test::implemented_ids()) {
    BatchOptions blind = batch_of(1, 7);
    blind.obs_mode = ObsMode::kNone;
    const auto unseen = make_env(id, blind);
    const auto seen = make_env(id, batch_of(1, 7));
    unseen->reset();
    seen->reset();
    for (int i = 0; i < 12; ++i) {
      test::step(*unseen, Policy::kOracle);
      test::step(*seen, Policy::kOracle);
    }
    const Bytes bytes = env_bytes(*seen, 0);
    const Bytes bytes_unseen = env_bytes(*unseen, 0);
    INFO(id);
    REQUIRE(bytes != bytes_unseen);
    const std::vector<std::byte> saved = Snapshotter(*seen).save();
    Snapshotter(*seen).restore(Snapshotter(*unseen).save());
    CHECK((env_bytes(*seen, 0) == bytes));
    Snapshotter(*unseen).restore(saved);
    CHECK((env_bytes(*unseen, 0) == bytes_unseen));
  }
}

TEST_CASE("A snapshot goes on by the rules of the batch it goes into", "[snapshot]") {
  const auto batch = make_running(kId, batch_of(1));
  for (int i = 0; i < batch->info().horizon; ++i) press(*batch);
  REQUIRE(batch->outputs().truncated[0] == 1);
  const std::vector<std::byte> ended = Snapshotter(*batch).save();

  const auto episode_after_step = [&](AutoReset rule) {
    BatchOptions options = batch_of(1, 40);
    options.auto_reset = rule;
    options.reward_mode = RewardMode::kSparse;
    const auto other = make_env(kId, options);
    Snapshotter(*other).restore(ended);
    press(*other);
    return std::pair(other->state().episode[0], other->state().elapsed[0]);
  };
  const auto horizon = batch->info().horizon;
  CHECK(episode_after_step(AutoReset::kNextStep) == std::pair(std::uint64_t{1}, 0));
  CHECK(episode_after_step(AutoReset::kSameStep) == std::pair(std::uint64_t{1}, 0));
  CHECK(episode_after_step(AutoReset::kOff) == std::pair(std::uint64_t{0}, horizon));
}

TEST_CASE("Saving needs a reset and an environment of the batch", "[snapshot]") {
  const auto batch = make_env(kId, batch_of(2));
  CHECK_THROWS_WITH(Snapshotter(*batch).save(), Catch::Contains("before the first reset"));
  CHECK_THROWS_WITH(Snapshotter(*batch).save_size(), Catch::Contains("before the first reset"));
  CHECK_THROWS_AS(Snapshotter(*batch).save(0), Error);
  CHECK_THROWS_AS(Snapshotter(*batch).save_size(0), Error);
  batch->reset();
  CHECK(Snapshotter(*batch).save().size() == Snapshotter(*batch).save_size());
  CHECK(Snapshotter(*batch).save(0).size() == Snapshotter(*batch).save_size(0));
  CHECK_THROWS_WITH(Snapshotter(*batch).save_size(2),
                    Catch::Contains("environment 2 given, 0 to 1 allowed"));
  const std::vector<std::byte> saved = Snapshotter(*batch).save(0);
  CHECK_THROWS_WITH(Snapshotter(*batch).save(2),
                    Catch::Contains("environment 2 given, 0 to 1 allowed"));
  CHECK_THROWS_AS(Snapshotter(*batch).restore(-1, saved), Error);
  const auto fresh = make_env(kId, batch_of(2));
  CHECK_THROWS_WITH(Snapshotter(*fresh).restore(0, saved),
                    Catch::Contains("before the first reset"));
}

}  // namespace
}  // namespace engram
