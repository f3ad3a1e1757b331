#include "bench/suites.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numeric>

#include "bench/budget_suite.h"
#include "bench/interleave.h"
#include "bench/mj_step_loop.h"
#include "bench/plain_loop.h"
#include "bench/process_usage.h"
#include "bench/render_suite.h"
#include "bench/rollout.h"
#include "bench/spin.h"
#include "core/base/join.h"
#include "protocol/make/make.h"

namespace engram::bench {
namespace {

// A step without physics, beside a whole step.
std::vector<Measurement> run_overhead(const SuiteOptions& options) {
  constexpr int kSteps = 400;
  const int n = envs_or(options, 64);
  MakeOptions bare = rollout_options(n, 1, options.physics);
  bare.substeps = 0;
  const std::string id = ids_or(options, {kMainId}).front();
  Rollout without(id, bare, Policy::kRandom);
  Rollout with(id, rollout_options(n, 1, options.physics), Policy::kRandom);
  const Comparison result = interleave(
      options, [&] { return 1e6 / without.rate(kSteps); },
      [&] { return 1e6 / with.rate(kSteps / 10); });
  return {make_measurement("overhead", "us per environment step", "with physics", result,
                           options.rounds)};
}

// A rollout and the plain loop of the same episodes, both timed over the same control steps.
Comparison compare_with_plain(const SuiteOptions& options, Rollout& rollout,
                              PlainLoop::SceneKind kind, int done, int total) {
  constexpr int kSteps = 25;
  PlainLoop plain(*rollout.batch, kind);
  double plain_seconds = 0;
  // Both advance together; the baseline's time is kept in plain_seconds.
  const auto both = [&] {
    double spent = 0;
    plain_seconds = 0;
    for (int i = 0; i < kSteps; ++i) {
      rollout.choose();
      const auto step_plain = [&] {
        plain_seconds += seconds([&] { plain.step(rollout.actions); });
      };
      // The order alternates, so that neither side always has the warmer caches.
      if (i % 2 == 0) step_plain();
      spent += rollout.step_seconds();
      if (i % 2 == 1) step_plain();
      plain.sync_scene();
    }
    return kSteps * rollout.batch->num_envs() / spent;
  };
  Rounds rounds;
  both();
  for (int round = 0; round < options.rounds; ++round) {
    const double rate = both();
    rounds.add(rate, kSteps * rollout.batch->num_envs() / plain_seconds);
    if (options.progress) options.progress((done + (round + 1.0) / options.rounds) / total);
  }
  return rounds.result();
}

Comparison compare_with_one_lane(const SuiteOptions& options, const std::string& id,
                                 MakeOptions batch_options) {
  constexpr int kSteps = 25;
  Rollout wide(id, batch_options, options.policy);
  batch_options.lanes = 1;
  Rollout single(id, batch_options, options.policy);
  return interleave(
      options, [&] { return wide.rate(kSteps); }, [&] { return single.rate(kSteps); });
}

// A rollout with MuJoCo's physics, and mj_step alone in the same control steps.
Comparison compare_with_mj_step(const SuiteOptions& options, Rollout& rollout, int done,
                                int total) {
  constexpr int kSteps = 25;
  MjStepLoop loop(*rollout.batch);
  Rounds rounds;
  for (int round = -1; round < options.rounds; ++round) {  // the first one warms up
    double spent = 0;
    double spent_by_loop = 0;
    for (int i = 0; i < kSteps; ++i) {
      rollout.choose();
      loop.note_states();
      spent += rollout.step_seconds();
      spent_by_loop += loop.step_seconds();
    }
    if (round < 0) continue;
    const double env_steps = kSteps * rollout.batch->num_envs();
    rounds.add(env_steps / spent, env_steps / spent_by_loop);
    if (options.progress) options.progress((done + (round + 1.0) / options.rounds) / total);
  }
  return rounds.result();
}

std::vector<Measurement> run_physics(const SuiteOptions& options) {
  const std::vector<std::string> ids =
      ids_or(options, {"RememberColor3-VLA-v0", kMainId, "RememberShapeAndColor5x3-VLA-v0",
                       "ChainOfColors7-VLA-v0"});
  std::vector<Measurement> rows;
  const bool mujoco = options.physics == Physics::kMujoco;
  const int total = (mujoco ? 1 : 3) * static_cast<int>(ids.size());
  for (const std::string& id : ids) {
    const int done = static_cast<int>(rows.size());
    MakeOptions batch_options =
        rollout_options(envs_or(options, mujoco ? 256 : 64), 1, options.physics);
    // The plain loop has no curriculum: both get the same live actions.
    batch_options.freeze_cue = false;
    batch_options.lanes = options.lanes;
    Rollout rollout(id, batch_options, options.policy);
    if (mujoco) {
      rows.push_back(
          make_measurement("physics." + id + ".vs_mj_step", "env steps/s", "mj_step of one mjData",
                           compare_with_mj_step(options, rollout, done, total), options.rounds));
      continue;
    }
    const Comparison full =
        compare_with_plain(options, rollout, PlainLoop::SceneKind::kFull, done, total);
    rows.push_back(make_measurement("physics." + id + ".vs_plain", "env steps/s",
                                    "mj_step on the whole scene", full, options.rounds));
    const Comparison robot =
        compare_with_plain(options, rollout, PlainLoop::SceneKind::kRobotAlone, done + 1, total);
    rows.push_back(make_measurement("physics." + id + ".vs_robot_alone", "env steps/s",
                                    "mj_step on robot and table alone", robot, options.rounds));
    rows.push_back(make_measurement(
        "physics." + id + ".vs_one_lane", "env steps/s", "the same engine with --lanes 1",
        compare_with_one_lane(options, id, batch_options), options.rounds));
  }
  return rows;
}

// A row of that name: two batches' rates in turns.
Measurement compare_rates(const SuiteOptions& options, std::string name, std::string baseline,
                          Rollout& value, Rollout& other, int steps, int done = 0, int total = 1) {
  const Comparison rates = interleave(
      options, [&] { return value.rate(steps); }, [&] { return other.rate(steps); }, done, total);
  return make_measurement(std::move(name), "env steps/s", std::move(baseline), rates,
                          options.rounds);
}

// All threads beside one, by the number of environments: rows scaling.n<N>.
void measure_batch_sizes(const SuiteOptions& options, const std::string& id, int most,
                         std::vector<Measurement>& rows) {
  constexpr int kStepsTimesEnvs = 25 * 256;
  for (const int n : {2, 8, 16, 32, 64, 128, 256, 1024}) {
    Rollout several(id, rollout_options(n, most, options.physics), options.policy);
    Rollout single(id, rollout_options(n, 1, options.physics), options.policy);
    rows.push_back(compare_rates(options, "scaling.n" + std::to_string(n), "one thread", several,
                                 single, std::max(25, kStepsTimesEnvs / n)));
  }
}

// More threads than processors: rows scaling.over.<K>.
void measure_excess_threads(const SuiteOptions& options, const std::string& id, int most, int n,
                            std::vector<Measurement>& rows) {
  Rollout usual(id, rollout_options(n, most, options.physics), options.policy);
  for (const int threads : {4 * most, 32 * most}) {
    Rollout several(id, rollout_options(n, threads, options.physics), options.policy);
    rows.push_back(compare_rates(options, "scaling.over." + std::to_string(threads),
                                 std::to_string(most) + " threads", several, usual, 25));
  }
}

// Ten tasks in one batch, beside the harmonic mean of as many environments of each: what they would
// take one after the other. All are at the same step of their episodes. Row scaling.tasks.
void measure_tasks(const SuiteOptions& options, int most, std::vector<Measurement>& rows) {
  constexpr int kSteps = 25;
  constexpr int kEach = 32;
  const std::vector<std::string> ids = {"RememberColor3-VLA-v0", "RememberColor9-VLA-v0",
                                        "RememberShape5-VLA-v0", "ShellGameTouch-VLA-v0",
                                        "InterceptSlow-VLA-v0",  "RotateLenientPos-VLA-v0",
                                        "TakeItBack-VLA-v0",     "FindImposterColor3-VLA-v0",
                                        "ChainOfColors3-VLA-v0", "RememberShapeAndColor3x2-VLA-v0"};
  const auto count = static_cast<int>(ids.size());
  GroupRollout together(ids, kEach, rollout_options(kEach, most, options.physics), options.policy);
  std::vector<std::unique_ptr<Rollout>> alone;
  for (const std::string& id : ids) {
    alone.push_back(std::make_unique<Rollout>(
        id, rollout_options(count * kEach, most, options.physics), options.policy));
  }
  const auto harmonic_mean = [&] {
    double sum = 0;
    for (const auto& one : alone) sum += 1 / one->rate(kSteps);
    return count / sum;
  };
  const Comparison rates = interleave(
      options, [&] { return together.rate(kSteps); }, harmonic_mean);
  rows.push_back(make_measurement("scaling.tasks", "env steps/s",
                                  "harmonic mean of the tasks alone", rates, options.rounds));
}

std::vector<Measurement> run_scaling(const SuiteOptions& options) {
  constexpr int kSteps = 25;
  const int most = threads_or_all(options.threads);
  const int n = envs_or(options, 256);
  const std::string id = ids_or(options, {kMainId}).front();
  Rollout single(id, rollout_options(n, 1, options.physics), options.policy);
  ThreadPool one(1);
  std::vector<Measurement> rows;
  for (int threads = 1; threads <= most; ++threads) {
    const int done = static_cast<int>(rows.size());
    Rollout several(id, rollout_options(n, threads, options.physics), options.policy);
    rows.push_back(compare_rates(options, "scaling." + std::to_string(threads), "one thread",
                                 several, single, kSteps, done, 2 * most));
    ThreadPool pool(threads);
    const Comparison spins = interleave(
        options, [&] { return spin(pool); }, [&] { return spin(one); }, done + 1, 2 * most);
    rows.push_back(make_measurement("scaling.spin." + std::to_string(threads), "items/s",
                                    "one thread", spins, options.rounds));
  }
  measure_batch_sizes(options, id, most, rows);
  measure_excess_threads(options, id, most, n, rows);
  if (options.ids.empty()) measure_tasks(options, most, rows);
  return rows;
}

// Whole steps that observe objects, beside those that observe the state.
std::vector<Measurement> run_objects(const SuiteOptions& options) {
  constexpr int kSteps = 25;
  const std::vector<std::string> ids =
      ids_or(options, {kMainId, "BatteriesCheckerHard-12-VLA-v0"});  // few tokens, and the most
  std::vector<Measurement> rows;
  for (const std::string& id : ids) {
    MakeOptions batch_options = rollout_options(envs_or(options, 256), 1, options.physics);
    Rollout state(id, batch_options, options.policy);
    batch_options.obs_mode = ObsMode::kObjects;
    Rollout objects(id, batch_options, options.policy);
    const Comparison rates = interleave(
        options, [&] { return objects.rate(kSteps); }, [&] { return state.rate(kSteps); },
        static_cast<int>(rows.size()), static_cast<int>(ids.size()));
    rows.push_back(make_measurement("objects." + id, "env steps/s", "the state observation", rates,
                                    options.rounds));
  }
  return rows;
}

// Resident bytes of a running batch of that size.
double batch_bytes(const SuiteOptions& options, const std::string& id, int num_envs) {
  const double before = process_usage().resident_bytes;
  Rollout rollout(id, rollout_options(num_envs, 1, options.physics), Policy::kRandom);
  rollout.rate(2);
  return process_usage().resident_bytes - before;
}

// Resident bytes of one mjData of the whole scene per environment.
double plain_bytes(const mjModel& model, int num_envs) {
  const double before = process_usage().resident_bytes;
  std::vector<DataPtr> data;
  for (int i = 0; i < num_envs; ++i) {
    data.push_back(make_data(model));
    mj_step(&model, data.back().get());
  }
  return process_usage().resident_bytes - before;
}

// Bytes of every further environment, beside those of an mjData of its own. The difference of two
// sizes leaves out constant parts.
std::vector<Measurement> run_memory(const SuiteOptions& options) {
  constexpr int kPlain = 64;
  const int n = envs_or(options, 8192);
  std::vector<Measurement> rows;
  const std::vector<std::string> ids = ids_or(options, {kMainId});
  for (const std::string& id : ids) {
    const double per_env = (batch_bytes(options, id, 2 * n) - batch_bytes(options, id, n)) / n;
    const Rollout some(id, rollout_options(1, 1, options.physics), Policy::kRandom);
    const mjModel& model = some.batch->physics_model().full();
    const double per_data = (plain_bytes(model, 2 * kPlain) - plain_bytes(model, kPlain)) / kPlain;
    // The name of the first row is a contract; further ids bring their own.
    rows.push_back({rows.empty() ? "memory" : "memory." + id, per_env, "bytes per environment",
                    "one mjData each", per_data, per_env / per_data, 1});
    if (options.progress) {
      options.progress(static_cast<double>(rows.size()) / static_cast<double>(ids.size()));
    }
  }
  return rows;
}

std::vector<Measurement> run_reset(const SuiteOptions& options) {
  const int n = envs_or(options, 256);
  const std::string id = ids_or(options, {kMainId}).front();
  Rollout rollout(id, rollout_options(n, 1, options.physics), Policy::kRandom);
  const mjModel& model = rollout.batch->physics_model().full();
  const DataPtr data = make_data(model);
  const Comparison result = interleave(
      options, [&] { return 1e6 / n * seconds([&] { rollout.batch->reset(); }); },
      [&] {
        return 1e6 / n * seconds([&] {
                 for (int i = 0; i < n; ++i) mj_resetData(&model, data.get());
               });
      });
  return {make_measurement("reset", "us per environment", "mj_resetData", result, options.rounds)};
}

std::vector<Measurement> run_create(const SuiteOptions& options) {
  const int n = envs_or(options, 256);
  const std::string id = ids_or(options, {kMainId}).front();
  const SceneSpec scene = make_task(id)->scene();
  std::vector<int> all(scene.props.size());
  std::iota(all.begin(), all.end(), 0);
  const Comparison result = interleave(
      options,
      [&] {
        return seconds(
            [&] { Rollout rollout(id, rollout_options(n, 1, options.physics), Policy::kRandom); });
      },
      [&] {
        return seconds([&] {
          const ModelPtr model = compile_model(scene.compose(all, RobotDetail::kCollision));
          std::vector<DataPtr> data;
          data.reserve(static_cast<std::size_t>(n));
          for (int i = 0; i < n; ++i) data.push_back(make_data(*model));
        });
      });
  return {make_measurement("create", "s for " + std::to_string(n) + " environments",
                           "one mjModel and mjData each", result, options.rounds)};
}

struct Suite {
  std::string_view name;
  std::vector<Measurement> (*run)(const SuiteOptions& options);
};

constexpr std::array<Suite, 9> kSuites = {{{"overhead", run_overhead},
                                           {"budget", run_budget},
                                           {"physics", run_physics},
                                           {"objects", run_objects},
                                           {"scaling", run_scaling},
                                           {"memory", run_memory},
                                           {"reset", run_reset},
                                           {"create", run_create},
                                           {"render", run_render}}};

constexpr auto kNames = [] {
  std::array<std::string_view, kSuites.size()> names;
  for (std::size_t i = 0; i < names.size(); ++i) names[i] = kSuites[i].name;
  return names;
}();

}  // namespace

std::span<const std::string_view> suite_names() { return kNames; }

std::vector<Measurement> run_suite(std::string_view suite, const SuiteOptions& options) {
  if (options.rounds < 1) {
    throw Error(Error::kInvalidArgument,
                "rounds: " + std::to_string(options.rounds) + " given, 1 or more allowed");
  }
  const auto* found = std::find_if(kSuites.begin(), kSuites.end(),
                                   [suite](const Suite& entry) { return entry.name == suite; });
  if (found == kSuites.end()) {
    throw Error(Error::kUnknownId,
                "no benchmark suite '" + std::string(suite) + "'; there are: " + join(kNames));
  }
  return found->run(options);
}

}  // namespace engram::bench
