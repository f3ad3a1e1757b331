// A task with rules outside of the library, here behind a C++ class.
#include <catch2/catch.hpp>
#include <cstring>
#include <map>

#include "core/base/error.h"
#include "core/batch/queries.h"
#include "core/batch/snapshot.h"
#include "mjcf/prop.h"
#include "tasks/custom/custom_family.h"
#include "tests/env_helpers.h"

namespace engram::tasks {
namespace {

using Catch::Contains;

// Counts steps in a column, and remembers what it was called with.
class CountingRules final : public CustomInstance {
 public:
  struct Log {
    std::vector<std::pair<CustomMethod, int>> calls;
    int of_all = 0;
    bool bad_status = false;
    ConstantTable constants;
  };

  explicit CountingRules(std::shared_ptr<Log> log) : log_(std::move(log)) {
    about_.props = {mjcf::cube("cube", 0.02, {1, 0, 0, 1})};
    about_.draws = {{.name = "goal", .low = 1, .high = 5, .text = "steps to success"}};
    about_.memory = {{{"count", 1, DType::kInt32, "", ""}, std::pair(0, 1000)}};
    about_.infos = {{{"steps_left", 1, DType::kInt32, "", "until success"}, std::nullopt}};
    about_.state_fields = {{"count", 1, DType::kFloat32, "", "steps so far"}};
    about_.hidden = "goal";
    about_.has_oracle = true;
  }

  const CustomDescription& description() const override { return about_; }
  void bind(std::span<const CustomArray> arrays, int /*num_envs*/) override {
    for (const CustomArray& array : arrays) arrays_[array.field.name] = array;
  }
  void call(CustomMethod method, int rows, bool of_all) override {
    log_->calls.emplace_back(method, rows);
    log_->of_all += of_all ? 1 : 0;
    const auto at = [&]<class T>(const char* name, T) {
      const CustomArray& array = arrays_.at(name);
      return reinterpret_cast<T*>(of_all ? array.all : array.subset_rows);
    };
    auto* count = at("memory:count", std::int32_t{});
    const auto* goal = at("draw:goal", std::int32_t{});
    for (int i = 0; i < rows; ++i) {
      switch (method) {
        case CustomMethod::kReset: {
          at("prop_quat", double{})[4 * i] = 1;
          at("prop_pos", double{})[3 * i + 2] = 0.02;
          at("prop_status", std::uint8_t{})[i] = log_->bad_status ? 7 : 1;
          at("moved", std::uint8_t{})[i] = 1;
          break;
        }
        case CustomMethod::kAdvance:
          ++count[i];
          break;
        case CustomMethod::kEvaluate:
          at("success", std::uint8_t{})[i] = count[i] > goal[i] ? 1 : 0;
          at("info:steps_left", std::int32_t{})[i] = goal[i] - count[i];
          break;
        case CustomMethod::kReward:
          at("reward", float{})[i] = static_cast<float>(count[i]);
          break;
        case CustomMethod::kObserve:
          at("state", float{})[i] = static_cast<float>(count[i]);
          break;
        case CustomMethod::kOracle:
          at("actions", float{})[7 * i + 6] = 1;
          break;
        default:
          break;
      }
    }
  }

 private:
  std::shared_ptr<Log> log_;
  CustomDescription about_;
  std::map<std::string, CustomArray> arrays_;
};

class CountingFactory final : public CustomFactory {
 public:
  explicit CountingFactory(std::shared_ptr<CountingRules::Log> log) : log_(std::move(log)) {}
  std::unique_ptr<CustomInstance> make(const std::string& /*id*/,
                                       const ConstantTable& constants) const override {
    log_->constants = constants;
    return std::make_unique<CountingRules>(log_);
  }

 private:
  std::shared_ptr<CountingRules::Log> log_;
};

constexpr const char* kId = "CountSteps-v0";

std::shared_ptr<CountingRules::Log> registered() {
  auto log = std::make_shared<CountingRules::Log>();
  register_custom({.id = kId,
                   .family = "CountSteps",
                   .horizon = 20,
                   .instruction = "Wait for {goal} steps.",
                   .memory_type = "Temporal",
                   .constants = {{.name = "SIZE",
                                  .kind = TaskConstant::Kind::kInteger,
                                  .value = 3,
                                  .low = 1,
                                  .high = 9}}},
                  std::make_shared<CountingFactory>(log));
  log->calls.clear();
  return log;
}

TEST_CASE("A task with rules outside of the library runs", "[own_tasks]") {
  const auto log = registered();
  CHECK(find_entry(kId)->split == Split::kExtended);
  const auto batch = test::make_running(kId, {.num_envs = 5, .reward_mode = RewardMode::kDense});
  CHECK(batch->info().horizon == 20);
  const auto* goals =
      reinterpret_cast<const std::int32_t*>(test::memory_of(*batch).find("draw:goal").data);
  for (int step = 1; step <= 6; ++step) {
    test::step(*batch, Policy::kOracle);
    for (int i = 0; i < 5; ++i) {
      CHECK(batch->outputs().reward[static_cast<std::size_t>(i)] == static_cast<float>(step + 1));
      CHECK((batch->outputs().success[static_cast<std::size_t>(i)] != 0) == (step + 1 > goals[i]));
      CHECK(*test::row<std::int32_t>(batch->output("steps_left"), i) == goals[i] - step - 1);
      CHECK(batch->outputs()
                .observation[static_cast<std::size_t>((i + 1) * batch->state_dim() - 1)] ==
            static_cast<float>(step + 1));
    }
  }
  CHECK(Queries(*batch).instruction(2) == "Wait for " + std::to_string(goals[2]) + " steps.");
  CHECK(log->of_all == static_cast<int>(log->calls.size()));
}

TEST_CASE("Rules see the environments concerned alone", "[own_tasks]") {
  const auto log = registered();
  const auto batch = test::make_running(kId, {.num_envs = 6, .auto_reset = AutoReset::kOff});
  test::step(*batch, Policy::kZero);
  log->calls.clear();
  const std::vector<std::uint8_t> mask = {0, 1, 0, 0, 1, 0};
  batch->reset({.mask = mask, .seeds = {}});
  for (const auto& [method, rows] : log->calls) CHECK(rows == 2);
  const auto* count =
      reinterpret_cast<const std::int32_t*>(test::memory_of(*batch).find("memory:count").data);
  for (int i = 0; i < 6; ++i) CHECK(count[i] == (mask[static_cast<std::size_t>(i)] != 0 ? 1 : 2));
}

TEST_CASE("Constants reach the rules, and wrong ones are refused", "[own_tasks]") {
  const auto log = registered();
  const auto batch = test::make_env(
      kId, MakeOptions{{}, {{"SIZE", Constant(7)}, {kHorizonConstant, Constant(4)}}});
  CHECK(batch->info().horizon == 4);
  CHECK(log->constants.front().second == Constant(7));
  CHECK_THROWS_WITH(make_task(kId, {{"SIZE", Constant(10)}}),
                    Contains("SIZE") && Contains("1 to 9"));
  CHECK_THROWS_WITH(make_task(kId, {{"SIZ", Constant(3)}}), Contains("SIZE"));
}

TEST_CASE("What rules remember is in snapshots", "[own_tasks][snapshot]") {
  registered();
  const BatchOptions options{.num_envs = 3};
  const auto batch = test::make_env(kId, options);
  const auto other = test::make_env(kId, options);
  batch->reset();
  other->reset();
  for (int step = 0; step < 3; ++step) test::step(*batch, Policy::kOracle);
  Snapshotter(*other).restore(Snapshotter(*batch).save());
  CHECK(test::batch_bytes(*batch) == test::batch_bytes(*other));
  test::step(*batch, Policy::kOracle);
  test::step(*other, Policy::kOracle);
  CHECK(test::batch_bytes(*batch) == test::batch_bytes(*other));
}

TEST_CASE("Scripts that a task lacks are refused", "[own_tasks][errors]") {
  registered();
  const auto batch = test::make_running(kId, BatchOptions());
  CHECK_THROWS_WITH(test::act(*batch, Policy::kSweep), "task 'CountSteps-v0': it has no sweep");
  test::step(*batch, Policy::kOracle);  // goes on
}

TEST_CASE("A status that no prop has is refused", "[own_tasks][errors]") {
  const auto log = registered();
  const auto batch = test::make_env(kId, BatchOptions());
  log->bad_status = true;
  CHECK_THROWS_WITH(batch->reset(), Contains("prop 'cube' has a status that there is not"));
  log->bad_status = false;
  batch->reset();
}

}  // namespace
}  // namespace engram::tasks
