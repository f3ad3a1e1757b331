// Ranges that resets narrow.
#include <catch2/catch.hpp>
#include <set>
#include <vector>

#include "core/batch/snapshot.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using Catch::Contains;

constexpr const char* kId = "RememberColor3-VLA-v0";
constexpr int kEnvs = 32;

std::unique_ptr<Batch> make() {
  return test::make_env(
      kId, MakeOptions{{.num_envs = kEnvs, .threads = 1},
                       {{"EMPTY_PHASE_STEPS", ConstantList{1, 60}}, {"max_episode_steps", 100}}});
}

int empty_steps(const Batch& batch, int index) {
  return *test::row<std::int32_t>(test::memory_of(batch).find("empty_steps"), index);
}

std::set<int> seen(const Batch& batch, int begin, int end) {
  std::set<int> values;
  for (int i = begin; i < end; ++i) values.insert(empty_steps(batch, i));
  return values;
}

TEST_CASE("Ranges are narrowed at reset, for the environments that are reset", "[variants]") {
  const auto batch = make();
  batch->reset();
  CHECK(*seen(*batch, 0, kEnvs).rbegin() > 20);

  const ConstantTable easy = {{"EMPTY_PHASE_STEPS", ConstantList{2, 4}}};
  std::vector<std::uint8_t> mask(kEnvs, 0);
  std::fill_n(mask.begin(), kEnvs / 2, std::uint8_t{1});
  batch->reset({.mask = mask, .seeds = {}, .pins = nullptr, .constants = &easy});
  CHECK(seen(*batch, 0, kEnvs / 2) == std::set<int>{2, 3, 4});
  CHECK(*seen(*batch, kEnvs / 2, kEnvs).rbegin() > 20);

  // They stay until others replace them; pins win.
  batch->reset();
  CHECK(seen(*batch, 0, kEnvs / 2) == std::set<int>{2, 3, 4});
  CHECK(*seen(*batch, kEnvs / 2, kEnvs).rbegin() > 20);
  const std::vector<Pin> pins = {{"empty_steps", {50}}};
  batch->reset({.mask = {}, .seeds = {}, .pins = &pins, .constants = &easy});
  CHECK(seen(*batch, 0, kEnvs) == std::set<int>{50});
  const std::vector<Pin> none;
  const ConstantTable whole;
  batch->reset({.mask = {}, .seeds = {}, .pins = &none, .constants = &whole});
  CHECK(*seen(*batch, 0, kEnvs / 2).rbegin() > 20);
}

TEST_CASE("A snapshot keeps the ranges of its environment", "[variants][snapshot]") {
  const auto batch = make();
  const ConstantTable easy = {{"EMPTY_PHASE_STEPS", 7}};
  batch->reset({.mask = {}, .seeds = {}, .pins = nullptr, .constants = &easy});
  const auto saved = Snapshotter(*batch).save();
  const auto other = make();
  other->reset();
  Snapshotter(*other).restore(saved);
  other->reset();
  CHECK(seen(*other, 0, kEnvs) == std::set<int>{7});
}

TEST_CASE("Ranges beyond the batch's are refused and change nothing", "[variants]") {
  const auto batch = make();
  batch->reset();
  const auto before = test::batch_bytes(*batch);
  struct Case {
    ConstantTable constants;
    const char* message;
  };
  const std::vector<Case> cases = {
      {{{"EMPTY_PHASE_STEPS", ConstantList{1, 61}}}, "from 1 to 60, allowed"},
      {{{"EMPTY_PHASE_STEPS", ConstantList{0, 4}}}, "[0, 4] given"},
      {{{"EMPTY_PHASE_STEPS", ConstantList{4, 3}}}, "[4, 3] given"},
      {{{"EMPTY_PHASE_STEPS", 2.5}}, "2.5 given"},
      {{{"EMPTY_PHASE_STEPS", "few"}}, "'few' given"},
      {{{"EMPTY_PHASE_STEP", 3}}, "did you mean 'EMPTY_PHASE_STEPS'"},
      {{{"COLORS", 2}}, "This task has: CUE_PHASE_STEPS, EMPTY_PHASE_STEPS"},
  };
  for (const Case& one : cases) {
    INFO(one.message);
    const ResetRequest request{
        .mask = {}, .seeds = {}, .pins = nullptr, .constants = &one.constants};
    CHECK_THROWS_WITH(batch->reset(request), Contains(one.message));
    CHECK(test::batch_bytes(*batch) == before);
  }
}

}  // namespace
}  // namespace engram
