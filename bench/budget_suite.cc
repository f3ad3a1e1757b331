#include "bench/budget_suite.h"

#include <algorithm>
#include <array>

#include "bench/rollout.h"
#include "core/base/step_clock.h"
#include "tasks/family_samples.h"

namespace engram::bench {
namespace {

constexpr std::size_t kBarrier = kStepParts;
constexpr std::size_t kOutside = kStepParts + 1;
constexpr std::size_t kShares = kStepParts + 2;

// The least number of ticks of a mark.
double cost_of_a_mark() {
  constexpr int kMarks = 1000;
  double least = 1e9;
  for (int turn = 0; turn < 20; ++turn) {
    StepClock::Worker worker;
    worker.start();
    const std::uint64_t begin = StepClock::now();
    for (int i = 0; i < kMarks; ++i) worker.mark(StepPart::kTask);
    least = std::min(least, static_cast<double>(StepClock::now() - begin) / kMarks);
  }
  return least;
}

// Parts of a step, as shares of the whole.
struct Budget {
  std::array<double, kShares> share{};
  double whole = 0;  // us per environment step
};

class BudgetMeter {
 public:
  BudgetMeter(const std::string& id, ObsMode obs, const SuiteOptions& options, int threads)
      : threads_(threads),
        clock_(threads),
        rollout_(id, batch_of(obs, options, threads), options.policy) {
    BatchAccess::data(*rollout_.batch).step_clock = &clock_;
  }

  Budget measure(int steps) {
    const StepClock::Ticks before = clock_.ticks();
    const StepClock::Ticks marks_before = clock_.marks();
    double ticks = 0;
    double spent = 0;
    for (int i = 0; i < steps; ++i) {
      rollout_.choose();
      const std::uint64_t begin = StepClock::now();
      spent += rollout_.step_seconds();
      ticks += static_cast<double>(StepClock::now() - begin);
    }
    const StepClock::Ticks after = clock_.ticks();
    const StepClock::Ticks marks_after = clock_.marks();
    std::array<double, kStepParts> cost{};  // of the marks, which a step without a clock has not
    double costs = 0;
    for (std::size_t part = 0; part < kStepParts; ++part) {
      cost[part] = ticks_per_mark_ * static_cast<double>(marks_after[part] - marks_before[part]);
      costs += cost[part];
    }
    const double all = ticks * threads_ - costs;
    Budget budget;
    budget.whole =
        1e6 * spent * threads_ / (steps * rollout_.batch->num_envs()) * all / (ticks * threads_);
    double marked = 0;
    for (std::size_t part = 0; part < kStepParts; ++part) {
      const double own = static_cast<double>(after[part] - before[part]) - cost[part];
      budget.share[part] = std::max(0.0, own) / all;
      marked += budget.share[part];
    }
    budget.share[kBarrier] = std::max(0.0, 1 - marked);
    budget.share[kOutside] = 1 - budget.share[static_cast<std::size_t>(StepPart::kDynamics)] -
                             budget.share[static_cast<std::size_t>(StepPart::kRender)];
    return budget;
  }

 private:
  static MakeOptions batch_of(ObsMode obs, const SuiteOptions& options, int threads) {
    MakeOptions result = rollout_options(envs_or(options, 256), threads, options.physics);
    result.obs_mode = obs;
    return result;
  }

  int threads_;
  double ticks_per_mark_ = cost_of_a_mark();
  StepClock clock_;
  Rollout rollout_;
};

void add_rows(std::vector<Measurement>& rows, const std::string& prefix,
              const std::vector<Budget>& rounds) {
  const auto median_of = [&rounds](auto&& value) {
    std::vector<double> values;
    values.reserve(rounds.size());
    for (const Budget& budget : rounds) values.push_back(value(budget));
    return median(std::move(values));
  };
  const double whole = median_of([](const Budget& budget) { return budget.whole; });
  for (std::size_t part = 0; part < kShares; ++part) {
    const double share = median_of([part](const Budget& budget) { return budget.share[part]; });
    const std::string_view name = part == kBarrier   ? "barrier"
                                  : part == kOutside ? "outside"
                                                     : kStepPartNames[part];
    rows.push_back({prefix + std::string(name), share * whole, "us per environment step",
                    "the whole step", whole, share, static_cast<int>(rounds.size())});
  }
}

}  // namespace

std::vector<Measurement> run_budget(const SuiteOptions& options) {
  const std::vector<std::string> ids = options.ids.empty() ? one_of_each_family() : options.ids;
  const int threads = threads_or_all(options.threads);
  std::vector<Measurement> rows;
  std::size_t done = 0;
  for (const std::string& id : ids) {
    for (const ObsMode obs : {ObsMode::kState, ObsMode::kRgb}) {
      const bool images = obs == ObsMode::kRgb;
      const int steps = images ? 3 : 10;
      BudgetMeter meter(id, obs, options, threads);
      meter.measure(steps);
      std::vector<Budget> rounds;
      rounds.reserve(static_cast<std::size_t>(options.rounds));
      for (int round = 0; round < options.rounds; ++round) rounds.push_back(meter.measure(steps));
      add_rows(rows, "budget." + id + (images ? ".rgb." : ".state."), rounds);
      ++done;
      if (options.progress) {
        options.progress(static_cast<double>(done) / (2.0 * static_cast<double>(ids.size())));
      }
    }
  }
  return rows;
}

}  // namespace engram::bench
