#include "bench/soak.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numeric>
#include <span>

#include "bench/interleave.h"
#include "bench/mixed_actions.h"
#include "bench/rollout.h"
#include "bench/spin.h"
#include "core/base/checksum.h"
#include "core/batch/queries.h"
#include "core/batch/scripted_policy.h"
#include "core/batch/snapshot.h"
#include "core/threads/thread_pool.h"
#include "protocol/make/make.h"
#include "protocol/make/rows.h"

namespace engram::bench {
namespace {

constexpr int kEnvs = 32;         // of a batch that is stepped
constexpr int kVisitSteps = 400;  // control steps of a visit, where there are enough
constexpr int kMinVisits = 3;     // of every task: one warms up, two are compared
constexpr int kProbeSteps = 20;
constexpr int kReferenceTurns = 5'000;  // about as long as a step of a batch
constexpr int kCycleSamples = 50;

// --- bounds ---

// Allowed growth: the heap's own bookkeeping, and pages that it keeps because the same pieces were
// freed in another order.
constexpr double kHeapSlack = 64.0 * 1024;
constexpr double kResidentSlack = 1024.0 * 1024;

// The samples from `low` to `high` of the work, both fractions.
std::span<const SoakSample> part_of(const std::vector<SoakSample>& samples, double low,
                                    double high) {
  const auto all = static_cast<double>(samples.back().done);
  const auto at = [&](double fraction) {
    return std::find_if(samples.begin(), samples.end() - 1, [&](const SoakSample& sample) {
      return static_cast<double>(sample.done) >= fraction * all;
    });
  };
  return {at(low), at(high) + 1};
}

template <class Member>
double least(std::span<const SoakSample> samples, Member member) {
  double value = static_cast<double>(samples.front().usage.*member);
  for (const SoakSample& sample : samples) {
    value = std::min(value, static_cast<double>(sample.usage.*member));
  }
  return value;
}

// Growth from the middle of the run, when every task has had its turn and caches are full, to its
// end. The heap keeps pieces for reuse and counts them as used, so the least of several samples is
// taken on both sides. A leak raises that too.
template <class Member>
double growth(const std::vector<SoakSample>& samples, Member member) {
  return least(part_of(samples, 0.8, 1.0), member) - least(part_of(samples, 0.4, 0.6), member);
}

void add_usage_bounds(const std::string& part, const std::vector<SoakSample>& samples,
                      std::vector<SoakBound>& bounds) {
  const auto add = [&](const char* name, double value, double allowed, const char* unit) {
    bounds.push_back({part + name, value, allowed, unit});
  };
  add(".heap_growth", growth(samples, &ProcessUsage::allocated_bytes), kHeapSlack, "bytes");
  add(".resident_growth", growth(samples, &ProcessUsage::resident_bytes), kResidentSlack, "bytes");
  add(".more_threads", growth(samples, &ProcessUsage::threads), 0, "threads");
  add(".more_descriptors", growth(samples, &ProcessUsage::descriptors), 0, "descriptors");
}

void add_visit_bounds(const SoakReport& report, double max_drift, std::vector<SoakBound>& bounds) {
  double grown = 0;
  int changed = 0;
  std::vector<double> drifts;
  for (const SoakTask& task : report.tasks) {
    if (task.visits.empty()) continue;  // stopped before
    for (const SoakVisit& visit : task.visits) {
      grown = std::max(grown, visit.grown_bytes);
      if (visit.digest != task.visits.front().digest) ++changed;
    }
    drifts.push_back(task.visits.back().drift);
  }
  bounds.push_back({"steps.heap_growth_in_a_visit", grown, 0, "bytes"});
  bounds.push_back({"steps.changed_results", static_cast<double>(changed), 0, "visits"});
  bounds.push_back({"steps.drift", median(drifts), max_drift, "times the first visit"});
  bounds.push_back({"steps.unstable", static_cast<double>(report.unstable.size()), 0, "episodes"});
}

// --- stepping ---

// Times the same steps in every visit: from the same seeds, with the same actions. Each is timed
// beside a piece of reference work, so that a machine that slows down slows down both.
struct ProbeResult {
  std::vector<double> costs;  // of every step, in units of the reference
  std::uint64_t digest = kChecksumSeed;
};

// Environment i begins episode 0 of seed + i.
void reset_from(Batch& batch, std::uint64_t seed) {
  std::vector<std::uint64_t> seeds(static_cast<std::size_t>(batch.num_envs()));
  std::iota(seeds.begin(), seeds.end(), seed);
  batch.reset({.mask = {}, .seeds = seeds, .pins = nullptr});
}

ProbeResult probe(Rollout& rollout, ThreadPool& reference, std::uint64_t seed) {
  Batch& batch = *rollout.batch;
  reset_from(batch, seed);
  ProbeResult result;
  for (int step = 0; step < kProbeSteps; ++step) {
    ScriptedPolicy(batch, Policy::kRandom).act(rollout.actions);
    const double before = seconds([&] { spin(reference, kReferenceTurns); });
    const double spent = rollout.step_seconds();
    const double after = seconds([&] { spin(reference, kReferenceTurns); });
    result.costs.push_back(2 * spent / (before + after));
    result.digest = checksum(std::as_bytes(batch.outputs().observation), result.digest);
    result.digest = checksum(std::as_bytes(batch.outputs().reward), result.digest);
  }
  return result;
}

// Index in kSoakPolicies of the policy of an environment in an episode.
std::size_t turn_of(int env, std::uint64_t episode) {
  return (static_cast<std::uint64_t>(env) + episode) % kSoakPolicies.size();
}

// The visits of one task. Between them it is a snapshot.
class TaskVisits {
 public:
  TaskVisits(std::string id, const SoakOptions& options, int visits) : options_(options) {
    task_.id = std::move(id);
    task_.visits.reserve(static_cast<std::size_t>(visits));
  }

  void visit(int steps, ThreadPool& reference, std::vector<UnstableEpisode>& unstable) {
    MakeOptions batch_options = rollout_options(kEnvs, reference.threads(), options_.physics);
    batch_options.seed = options_.seed;
    Rollout rollout(task_.id, batch_options, Policy::kRandom);
    Batch& batch = *rollout.batch;
    SoakVisit visit;
    measure(rollout, reference, visit);
    resume(batch);
    MixedActions actions(batch);
    const auto solved = [&batch](int i) {
      return kSoakPolicies[turn_of(i, batch.state().episode[i])] == Policy::kOracle;
    };
    const Queries queries(batch);
    std::uint64_t diverged = queries.unstable_count();
    const double heap = allocated_bytes();
    const double spent = seconds([&] {
      for (int step = 0; step < steps; ++step) {
        batch.step(actions.choose(batch, solved));
        count_episodes(batch, visit);
        if (queries.unstable_count() == diverged) continue;
        diverged = queries.unstable_count();
        note_unstable(batch, unstable);
      }
    });
    visit.grown_bytes = allocated_bytes() - heap;
    visit.env_steps_per_second = static_cast<double>(steps) * kEnvs / spent;
    snapshot_ = Snapshotter(batch).save();
    task_.visits.push_back(visit);
  }

  SoakTask& result() { return task_; }

 private:
  void measure(Rollout& rollout, ThreadPool& reference, SoakVisit& visit) {
    const ProbeResult probed = probe(rollout, reference, options_.seed);
    if (first_costs_.empty()) first_costs_ = probed.costs;
    std::vector<double> quotients;
    for (std::size_t i = 0; i < probed.costs.size(); ++i) {
      quotients.push_back(probed.costs[i] / first_costs_[i]);
    }
    visit.drift = median(quotients);
    visit.digest = probed.digest;
  }

  // Restores the end of the last visit; the first visit begins with episode 0 of its seeds.
  void resume(Batch& batch) const {
    if (snapshot_.empty()) {
      reset_from(batch, options_.seed);
    } else {
      Snapshotter(batch).restore(snapshot_);
    }
  }

  static void count_episodes(const Batch& batch, SoakVisit& visit) {
    const ColumnView succeeded = batch.final_output("success_once");
    for (int i = 0; i < kEnvs; ++i) {
      if (batch.outputs().final_mask[static_cast<std::size_t>(i)] == 0) continue;
      const std::size_t turn = turn_of(i, batch.state().episode[i] - 1);
      ++visit.episodes[turn];
      visit.successes[turn] += value_of<std::uint8_t>(succeeded, i);
    }
  }

  // The episode that diverged has ended; its successor has begun.
  void note_unstable(const Batch& batch, std::vector<UnstableEpisode>& unstable) const {
    const ColumnView elapsed = batch.final_output("elapsed_steps");
    for (int i = 0; i < kEnvs; ++i) {
      if (batch.outputs().unstable[static_cast<std::size_t>(i)] == 0) continue;
      const std::uint64_t episode = batch.state().episode[i] - 1;
      unstable.push_back({task_.id, batch.state().seed[i], episode,
                          kSoakPolicies[turn_of(i, episode)], value_of<std::int32_t>(elapsed, i)});
    }
  }

  const SoakOptions& options_;
  SoakTask task_;
  std::vector<double> first_costs_;
  std::vector<std::byte> snapshot_;
};

// Every task is visited several times, in turns.
struct VisitPlan {
  int visits = 0;
  int steps = 0;  // of a visit
};

VisitPlan plan_visits(std::int64_t env_steps, std::size_t tasks) {
  const double per_env = static_cast<double>(env_steps) / static_cast<double>(tasks) / kEnvs;
  const int visits = std::max(kMinVisits, static_cast<int>(per_env / kVisitSteps));
  return {visits, static_cast<int>(std::ceil(per_env / visits))};
}

class Soak {
 public:
  Soak(const SoakOptions& options, std::vector<std::string> ids)
      : options_(options), ids_(std::move(ids)) {
    report_.threads = threads_or_all(options.threads);
  }

  SoakReport run() {
    if (options_.env_steps > 0) {
      report_.step_seconds = seconds([this] { run_visits(); });
      add_usage_bounds("steps", report_.step_samples, report_.bounds);
      add_visit_bounds(report_, options_.max_drift, report_.bounds);
    }
    if (options_.cycles > 0 && !report_.stopped) {
      report_.cycle_seconds = seconds([this] { run_cycles(); });
      add_usage_bounds("cycles", report_.cycle_samples, report_.bounds);
    }
    return std::move(report_);
  }

 private:
  void run_visits() {
    const VisitPlan plan = plan_visits(options_.env_steps, ids_.size());
    // Lists grow here, not while the heap is measured.
    report_.step_samples.reserve(ids_.size() * static_cast<std::size_t>(plan.visits));
    std::vector<TaskVisits> tasks;
    for (const std::string& id : ids_) tasks.emplace_back(id, options_, plan.visits);
    for (int visit = 0; visit < plan.visits && !report_.stopped; ++visit) {
      for (TaskVisits& task : tasks) {
        if (stop()) break;
        {
          ThreadPool reference(report_.threads);
          task.visit(plan.steps, reference, report_.unstable);
        }
        report_.env_steps += static_cast<std::int64_t>(plan.steps) * kEnvs;
        report_.step_samples.push_back({report_.env_steps, process_usage()});
        report_progress(static_cast<double>(report_.step_samples.size()) /
                        static_cast<double>(report_.step_samples.capacity()) *
                        (options_.cycles > 0 ? 0.5 : 1));
      }
    }
    for (TaskVisits& task : tasks) report_.tasks.push_back(std::move(task.result()));
  }

  void run_cycles() {
    // Odd, so that it meets batches of every kind.
    const int interval = options_.cycles / kCycleSamples | 1;
    report_.cycle_samples.reserve(static_cast<std::size_t>(options_.cycles / interval + 1));
    const double begun = options_.env_steps > 0 ? 0.5 : 0;
    for (int done = 0; done < options_.cycles && !stop(); ++done) {
      make_and_close(done);
      ++report_.cycles;
      if (report_.cycles % interval == 0 || report_.cycles == options_.cycles) {
        report_.cycle_samples.push_back({report_.cycles, process_usage()});
      }
      report_progress(begun + (1 - begun) * report_.cycles / options_.cycles);
    }
  }

  // Batches of several sizes, with and without images, that live for a while or not at all.
  void make_and_close(int cycle) const {
    const std::string& id = ids_[static_cast<std::size_t>(cycle) % ids_.size()];
    MakeOptions batch_options = rollout_options(1 + cycle % 4, 1 + cycle % 5, options_.physics);
    if (cycle % 10 == 9) {
      batch_options.obs_mode = ObsMode::kRgb;
      batch_options.images.width = 32;
      batch_options.images.height = 32;
    }
    if (cycle % 7 == 6) {
      refuse(id, batch_options);
      return;
    }
    const auto batch = make(id, batch_options);
    if (cycle % 3 == 0) return;
    batch->reset();
    if (cycle % 3 == 1) return;
    std::vector<float> actions(static_cast<std::size_t>(batch->num_envs() * batch->action_dim()));
    ScriptedPolicy(*batch, Policy::kOracle).act(actions);
    batch->step(actions);
  }

  // A batch that fails halfway must leave nothing behind either.
  static void refuse(const std::string& id, MakeOptions batch_options) {
    batch_options.pins = {{"no such draw", {0}}};
    try {
      make(id, batch_options);
    } catch (const Error& error) {
      if (error.kind() == Error::kInvalidArgument || error.kind() == Error::kUnknownId) return;
      throw;
    }
    throw Error(Error::kInternal,
                "a batch of " + id + " was made with a pin that it does not have");
  }

  // Only after the first sample, so that there is something to report.
  bool stop() {
    const bool begun = !report_.step_samples.empty() || !report_.cycle_samples.empty();
    if (begun && options_.stop && options_.stop()) report_.stopped = true;
    return report_.stopped;
  }

  void report_progress(double fraction) const {
    if (options_.progress) options_.progress(fraction);
  }

  const SoakOptions& options_;
  const std::vector<std::string> ids_;
  SoakReport report_;
};

}  // namespace

bool SoakReport::passed() const {
  return std::all_of(bounds.begin(), bounds.end(),
                     [](const SoakBound& bound) { return bound.kept(); });
}

SoakReport soak(const SoakOptions& options) {
  if (options.env_steps < 0 || options.cycles < 0) {
    throw Error(Error::kInvalidArgument,
                "soak: " + std::to_string(options.env_steps) + " environment steps and " +
                    std::to_string(options.cycles) + " cycles given, 0 or more allowed");
  }
  std::vector<std::string> ids = options.ids;
  for (const std::string& id : ids) require_entry(id);
  if (ids.empty()) {
    for (const RegistryEntry& entry : registry()) {
      ids.emplace_back(entry.id);
    }
  }
  return Soak(options, std::move(ids)).run();
}

}  // namespace engram::bench
