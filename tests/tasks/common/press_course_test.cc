// Whole courses of touches and presses, for every task that has a button: the same bits again after
// a reset, in another batch, and after a snapshot in the middle of a press.
#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "core/batch/snapshot.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::Bytes, test::make_env, test::make_running, test::row;

// Every draw that makes an episode long at its least, so that the course begins soon.
BatchOptions shortened(const std::string& id, int num_envs = 1) {
  BatchOptions options{.num_envs = num_envs, .auto_reset = AutoReset::kOff};
  const auto task = make_task(id);
  for (const RandomVariable& draw : task->info().random_variables) {
    const bool waits = draw.unit == "control steps" || draw.name == "target_blinks";
    if (waits) {
      options.pins.push_back(
          {draw.name, std::vector<double>(static_cast<std::size_t>(draw.width), draw.low)});
    }
  }
  return options;
}

std::vector<std::string> ids_with_button() {
  std::vector<std::string> ids;
  for (const char* family :
       {"BunchOfColors", "SeqOfColors", "ChainOfColors", "BlinkCountButtonPress"}) {
    const std::vector<std::string> more = test::vla_ids(family);
    ids.insert(ids.end(), more.begin(), more.end());
  }
  return ids;
}

bool pending(const Batch& batch) {
  for (const char* name : {"center_button_pending", "button_pending"}) {
    const ColumnView view = test::memory_of(batch).find(name);
    if (view.field != nullptr) return *row<std::uint8_t>(view, 0) != 0;
  }
  FAIL("no button");
  return false;
}

// Bytes of the first environment after every further step of the oracle.
std::vector<Bytes> course(Batch& batch, int steps) {
  std::vector<Bytes> history;
  for (int i = 0; i < steps; ++i) {
    test::step(batch, Policy::kOracle);
    history.push_back(test::env_bytes(batch, 0));
  }
  return history;
}

TEST_CASE("A snapshot in the middle of a press goes on bit for bit", "[snapshot][button]") {
  for (const std::string& id : ids_with_button()) {
    INFO(id);
    const auto batch = make_running(id, shortened(id));
    for (int i = 0; i < batch->info().horizon && !pending(*batch); ++i) {
      test::step(*batch, Policy::kOracle);
    }
    REQUIRE(pending(*batch));
    const std::vector<std::byte> saved = Snapshotter(*batch).save();
    const std::vector<Bytes> expected = course(*batch, 12);
    CHECK_FALSE(pending(*batch));
    const auto fresh = make_env(id, shortened(id));
    Snapshotter(*fresh).restore(saved);
    CHECK((course(*fresh, 12) == expected));
    Snapshotter(*batch).restore(saved);
    CHECK((course(*batch, 12) == expected));
  }
}

TEST_CASE("Courses of presses repeat after a reset and in a batch", "[determinism][button]") {
  for (const std::string& id : ids_with_button()) {
    INFO(id);
    const auto single = make_running(id, shortened(id));
    std::vector<Bytes> expected;
    while (single->outputs().success[0] == 0 && single->state().finished[0] == 0) {
      test::step(*single, Policy::kOracle);
      expected.push_back(test::env_bytes(*single, 0));
    }
    CHECK(single->outputs().success[0] == 1);
    const int steps = static_cast<int>(expected.size());
    const std::vector<std::uint64_t> seeds = {single->options().seed};
    single->reset({.mask = {}, .seeds = seeds, .pins = nullptr});
    CHECK((course(*single, steps) == expected));
    BatchOptions options = shortened(id, 3);
    options.threads = 3;
    const auto batch = make_running(id, options);
    CHECK((course(*batch, steps) == expected));
  }
}

}  // namespace
}  // namespace engram
