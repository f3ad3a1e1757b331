#include "apps/soak_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>

#include "apps/interruption.h"
#include "apps/options.h"
#include "apps/output.h"
#include "apps/progress.h"
#include "bench/soak.h"
#include "protocol/io/json.h"

namespace engram::apps {
namespace {

struct SoakCommandOptions {
  bench::SoakOptions soak;
  bool json = false;
};

JsonTable describe(const bench::SoakSample& sample) {
  return {{"done", sample.done},
          {"resident_bytes", sample.usage.resident_bytes},
          {"allocated_bytes", sample.usage.allocated_bytes},
          {"threads", sample.usage.threads},
          {"descriptors", sample.usage.descriptors}};
}

JsonTable describe(const bench::SoakVisit& visit) {
  JsonTable table = {{"env_steps_per_second", visit.env_steps_per_second},
                     {"drift", visit.drift},
                     {"digest", fmt::format("{:016x}", visit.digest)},
                     {"grown_bytes", visit.grown_bytes}};
  for (std::size_t i = 0; i < bench::kSoakPolicies.size(); ++i) {
    table.emplace_back(
        name_of(bench::kSoakPolicies[i]),
        JsonTable{{"episodes", visit.episodes[i]}, {"success_once", visit.successes[i]}});
  }
  return table;
}

JsonTable describe(const bench::SoakTask& task) {
  JsonList visits;
  visits.reserve(task.visits.size());
  for (const bench::SoakVisit& visit : task.visits) visits.emplace_back(describe(visit));
  return {{"id", task.id}, {"visits", std::move(visits)}};
}

JsonTable describe(const bench::UnstableEpisode& episode) {
  return {{"id", episode.id},
          {"seed", episode.seed},
          {"episode", episode.episode},
          {"policy", name_of(episode.policy)},
          {"elapsed", episode.elapsed}};
}

JsonTable describe(const bench::SoakBound& bound) {
  return {{"name", bound.name},
          {"value", bound.value},
          {"allowed", bound.allowed},
          {"unit", bound.unit},
          {"kept", bound.kept()}};
}

template <class T>
JsonList describe_all(const std::vector<T>& items) {
  JsonList list;
  list.reserve(items.size());
  for (const T& item : items) list.emplace_back(describe(item));
  return list;
}

JsonTable to_document(const bench::SoakReport& report) {
  return {{"env_steps", report.env_steps},
          {"cycles", report.cycles},
          {"threads", report.threads},
          {"stopped", report.stopped},
          {"step_seconds", report.step_seconds},
          {"cycle_seconds", report.cycle_seconds},
          {"passed", report.passed()},
          {"bounds", describe_all(report.bounds)},
          {"unstable", describe_all(report.unstable)},
          {"tasks", describe_all(report.tasks)},
          {"step_samples", describe_all(report.step_samples)},
          {"cycle_samples", describe_all(report.cycle_samples)}};
}

// --- text ---

std::string share(int successes, int episodes) {
  return episodes > 0
             ? fmt::format("{:.3f} of {}", successes / static_cast<double>(episodes), episodes)
             : "-";
}

std::string tasks_table(const std::vector<bench::SoakTask>& tasks) {
  Table table({{"task"},
               {"env steps/s first", true},
               {"last", true},
               {"drift", true},
               {"random succeeds", true},
               {"oracle", true}});
  for (const bench::SoakTask& task : tasks) {
    if (task.visits.empty()) continue;  // interrupted before
    std::array<int, 2> episodes{};
    std::array<int, 2> successes{};
    for (const bench::SoakVisit& visit : task.visits) {
      for (std::size_t i = 0; i < episodes.size(); ++i) {
        episodes[i] += visit.episodes[i];
        successes[i] += visit.successes[i];
      }
    }
    table.add({task.id, with_thousands(task.visits.front().env_steps_per_second),
               with_thousands(task.visits.back().env_steps_per_second),
               fmt::format("{:.3f}", task.visits.back().drift), share(successes[0], episodes[0]),
               share(successes[1], episodes[1])});
  }
  return table.text();
}

// The first sample, the last one, and some in between.
std::string samples_table(const char* unit, const std::vector<bench::SoakSample>& samples) {
  constexpr std::size_t kRows = 11;
  Table table({{unit, true},
               {"resident kB", true},
               {"heap in use kB", true},
               {"threads", true},
               {"descriptors", true}});
  for (std::size_t row = 0; row < kRows; ++row) {
    const std::size_t index = row * (samples.size() - 1) / (kRows - 1);
    if (row > 0 && index == (row - 1) * (samples.size() - 1) / (kRows - 1)) continue;
    const bench::SoakSample& sample = samples[index];
    table.add({with_thousands(static_cast<double>(sample.done)),
               with_thousands(sample.usage.resident_bytes / 1024),
               with_thousands(sample.usage.allocated_bytes / 1024),
               std::to_string(sample.usage.threads), std::to_string(sample.usage.descriptors)});
  }
  return table.text();
}

std::string to_plain_text(const bench::SoakReport& report) {
  std::string text;
  if (!report.tasks.empty()) {
    text += fmt::format("{} env steps of {} tasks in {:.0f} s, {} threads\n\n{}\n{}\n",
                        with_thousands(static_cast<double>(report.env_steps)), report.tasks.size(),
                        report.step_seconds, report.threads, tasks_table(report.tasks),
                        samples_table("env steps", report.step_samples));
  }
  if (report.cycles > 0) {
    text +=
        fmt::format("{} batches made and closed in {:.0f} s\n\n{}\n", with_thousands(report.cycles),
                    report.cycle_seconds, samples_table("cycles", report.cycle_samples));
  }
  for (const bench::UnstableEpisode& episode : report.unstable) {
    text += fmt::format("unstable: {} seed {} episode {} policy {} step {}\n", episode.id,
                        episode.seed, episode.episode, name_of(episode.policy), episode.elapsed);
  }
  Table table({{"bound"}, {"value", true}, {"allowed", true}, {"unit"}, {""}});
  for (const bench::SoakBound& bound : report.bounds) {
    table.add({bound.name, fmt::format("{:.10g}", bound.value),
               fmt::format("{:.10g}", bound.allowed), bound.unit, bound.kept() ? "" : "BROKEN"});
  }
  return text + table.text();
}

void run(const SoakCommandOptions& given) {
  bench::SoakOptions options = given.soak;
  bench::SoakReport report;
  {
    const Interruption interruption(0);  // there is a report to make
    Progress progress("soak", "");
    options.progress = [&progress](double fraction) { progress.update(fraction); };
    options.stop = [&interruption] { return interruption.requested(); };
    report = bench::soak(options);
  }
  print(given.json ? to_text(to_document(report)) : to_plain_text(report));
  std::vector<std::string> broken;
  for (const bench::SoakBound& bound : report.bounds) {
    if (!bound.kept()) broken.push_back(bound.name);
  }
  if (!broken.empty()) {
    throw Error(Error::kInternal, fmt::format("soak: bounds broken: {}", fmt::join(broken, ", ")));
  }
  if (report.stopped) {
    throw Error(Error::kIo, "interrupted; reported is what was done until then");
  }
}

}  // namespace

void add_soak_command(const Command& program) {
  const auto options = std::make_shared<SoakCommandOptions>();
  const Command command = program.add_command(
      "soak",
      "Long runs that watch for growth, drift and instability; a broken bound is a failure");
  command.add_option("id", options->soak.ids, "Tasks to run; default: all").type_name("ID");
  bench::SoakOptions& soak = options->soak;
  command
      .add_option(
          "--env-steps",
          [&soak](const std::string& text) {
            soak.env_steps = static_cast<std::int64_t>(
                parse_unsigned("--env-steps", text, 0, std::uint64_t{1} << 50));
          },
          "Environment steps in total, rounded up to whole visits of every task; 0: none")
      .type_name("N")
      .default_str(std::to_string(soak.env_steps));
  add_int(command, "--cycles", soak.cycles, 0, std::numeric_limits<int>::max(),
          "Batches that are made and closed afterwards; 0: none");
  add_seed(command, soak.seed, "Environment i begins with seed + i");
  add_threads(command, soak.threads);
  add_physics(command, soak.physics);
  command
      .add_positive("--max-drift", soak.max_drift,
                    "How much longer a fixed piece of work may take in a task's last visit than in "
                    "its first, beside a reference: the median over all tasks")
      .type_name("TIMES");
  add_json(command, options->json);
  command.footer(
      "Every task is visited several times; its environments run random and oracle episodes in "
      "turn. Memory, threads and descriptors of the "
      "process at the end are compared with those in the middle.");
  command.on_run([options] { run(*options); });
}

}  // namespace engram::apps
