#include "apps/bench_command.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "apps/options.h"
#include "apps/output.h"
#include "apps/progress.h"
#include "bench/suites.h"
#include "protocol/io/json.h"

namespace engram::apps {
namespace {

constexpr int kMaxRounds = 100'000;
constexpr std::string_view kAllSuites = "all";

struct BenchOptions {
  std::string suite;
  bench::SuiteOptions bench;
  bool json = false;
};

std::vector<bench::Measurement> run_suites(const BenchOptions& options) {
  std::vector<std::string_view> suites = {options.suite};
  if (options.suite == kAllSuites) {
    suites.assign(bench::suite_names().begin(), bench::suite_names().end());
  }
  Progress progress("bench", "");
  std::vector<bench::Measurement> rows;
  double done = 0;
  bench::SuiteOptions bench_options = options.bench;
  bench_options.progress = [&](double fraction) {
    progress.update((done + fraction) / static_cast<double>(suites.size()));
  };
  for (const std::string_view suite : suites) {
    for (bench::Measurement& row : bench::run_suite(suite, bench_options))
      rows.push_back(std::move(row));
    ++done;
  }
  return rows;
}

// Rows that are compared with nothing have null where the comparison would be.
JsonTable describe(const bench::Measurement& row) {
  const bool compared = !row.baseline.empty();
  const auto or_null = [compared](auto value) { return compared ? Json(value) : Json(); };
  return {{"name", row.name},
          {"value", row.value},
          {"unit", row.unit},
          {"baseline", or_null(row.baseline)},
          {"baseline_value", or_null(row.baseline_value)},
          {"ratio", or_null(row.ratio)},
          {"rounds", row.rounds}};
}

std::string number(double value) {
  return std::abs(value) >= 1000 ? with_thousands(value) : fmt::format("{:.4g}", value);
}

std::string to_plain_text(const std::vector<bench::Measurement>& rows) {
  Table table({{"name"},
               {"value", true},
               {"unit"},
               {"baseline"},
               {"its value", true},
               {"ratio", true},
               {"rounds", true}});
  for (const bench::Measurement& row : rows) {
    const bool compared = !row.baseline.empty();
    table.add({row.name, number(row.value), row.unit, compared ? row.baseline : "-",
               compared ? number(row.baseline_value) : "-",
               compared ? fmt::format("{:.3f}", row.ratio) : "-", std::to_string(row.rounds)});
  }
  return table.text();
}

void run(const BenchOptions& options) {
  const std::vector<bench::Measurement> rows = run_suites(options);
  if (!options.json) {
    print(to_plain_text(rows));
    return;
  }
  JsonList document;
  document.reserve(rows.size());
  for (const bench::Measurement& row : rows) document.emplace_back(describe(row));
  print(to_text(document));
}

}  // namespace

void add_bench_command(const Command& program) {
  static constexpr Policy kPolicies[] = {Policy::kRandom, Policy::kOracle};
  const auto options = std::make_shared<BenchOptions>();
  const Command command =
      program.add_command("bench", "Side-by-side benchmarks, interleaved in one process");
  command
      .add_option("suite", options->suite,
                  fmt::format("{} or {}", fmt::join(bench::suite_names(), ", "), kAllSuites))
      .required()
      .type_name("SUITE");
  command.add_option("--id", options->bench.ids, "Tasks to measure; default: the suite's own")
      .type_name("ID");
  add_int(command, "--rounds", options->bench.rounds, 1, kMaxRounds,
          "Rounds in which the sides take turns");
  add_policy(command, options->bench.policy, kPolicies);
  add_int(command, "--num-envs", options->bench.num_envs, 0, kMaxNumEnvs,
          "Environments stepped together; 0: the suite's own number");
  add_threads(command, options->bench.threads);
  add_lanes(command, options->bench.lanes);
  add_physics(command, options->bench.physics);
  add_json(command, options->json);
  command.on_run([options] { run(*options); });
}

}  // namespace engram::apps
