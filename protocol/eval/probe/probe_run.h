// Probes of a policy's memory (docs/probe.md), on all threads of one process or of several.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "protocol/eval/probe/probe_plan.h"
#include "protocol/eval/run/settings.h"
#include "protocol/parallel/ranks.h"
#include "protocol/parallel/run_header.h"

namespace engram {

enum class Probe { kTwins, kForgetting, kInterference, kCapacity };
inline constexpr std::array kProbeNames = {"twins", "forgetting", "interference", "capacity"};
constexpr const auto& names_of(Probe) { return kProbeNames; }

struct ProbeOptions {
  std::vector<Probe> probes = {Probe::kTwins, Probe::kForgetting, Probe::kInterference,
                               Probe::kCapacity};
  std::string other = {};  // id of the task of further episodes of interference; empty: none
  // Folder that the results are to go to, made once all else is checked; empty: none.
  std::filesystem::path output = {};
};

// Words of a list such as "twins,capacity". Throws Error (kInvalidArgument) for others.
std::vector<Probe> parse_probes(std::string_view option, const std::string& text);

// episodes: numbers that are done at all points, of all.
using ProbeProgress = std::function<void(int episodes, int all, std::uint64_t env_steps)>;

// The plans of a task's probes, and the place of each one's conditions among those of the run.
struct TaskSections {
  struct Section {
    Probe probe = Probe::kTwins;
    ProbePlan plan;
    std::size_t first = 0;
  };
  const RegistryEntry* entry = nullptr;
  std::vector<Section> sections;
};

// Kind of a run, in journals.
inline constexpr const char* kProbeKind = "probe";

class ProbeRun {
 public:
  // protocol: with these settings, policy, threads and environments at a time, on which results do
  // not depend. Throws Error (kInvalidArgument), before anything is played or made, for settings
  // that probes do not have.
  ProbeRun(EvaluationSettings settings, Protocol protocol, ProbeOptions options);

  // {settings, tasks}: of each task of the settings, what the probes have found. All ranks call it,
  // with the same settings, policy and options; only rank 0's document, progress, store and output
  // folder count. The document does not depend on the number of ranks; a shard has none.
  Json play(Ranks& ranks, const ProbeProgress& progress, const EpisodeStore& store = {});
  // Header of its journal.
  RunHeader header(const EpisodePart& part) const;

 private:
  Json document(const std::vector<ConditionResults>& results) const;

  EvaluationSettings settings_;
  Protocol protocol_;
  ProbeOptions options_;
  std::vector<TaskSections> tasks_;
  std::vector<ProbeCondition> conditions_;  // of all tasks
};

// The document of a run in this process alone.
Json run_probes(const EvaluationSettings& settings, const Protocol& protocol,
                const ProbeOptions& options, const ProbeProgress& progress);

}  // namespace engram
