// Probes of a policy's memory (docs/probe.md), on all threads of this process.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "protocol/evaluation/settings.h"

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

// {settings, tasks}: of each task of the settings, what the probes have found. protocol: with these
// settings, policy, threads and environments at a time, on which results do not depend. Throws
// Error (kInvalidArgument), before anything is played or made, for settings that probes do not
// have.
Document run_probes(const EvaluationSettings& settings, const Protocol& protocol,
                    const ProbeOptions& options, const ProbeProgress& progress);

}  // namespace engram
