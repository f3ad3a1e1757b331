#include "protocol/parallel/launcher.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string_view>
#include <vector>

namespace engram {
namespace {

// Open MPI's own, and those of Slurm and others with PMI.
constexpr const char* kSizeVariables[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"};

// Beginnings of the names of programs that start ranks: of Open MPI, MPICH, Slurm,
// Cray's ALPS and PALS, Flux.
constexpr std::string_view kLaunchers[] = {"orte",    "prte",   "prun",      "mpirun",
                                           "mpiexec", "hydra_", "pmi_proxy", "slurmstepd",
                                           "srun",    "apinit", "pals",      "flux-"};

// Programs that start the one they are given: shells for scripts, and those of containers.
constexpr std::string_view kWrappers[] = {
    "sh",           "bash",      "dash",        "ash",     "zsh",     "ksh",   "busybox",
    "env",          "time",      "timeout",     "nice",    "numactl", "xargs", "starter",
    "starter-suid", "apptainer", "singularity", "appinit", "sinit"};

struct Process {
  std::string name;
  pid_t parent = 0;
  pid_t group = 0;
};

// "PID (NAME) STATE PARENT GROUP ..."; the name may hold anything.
std::optional<Process> process_of(pid_t id) {
  std::ifstream file("/proc/" + std::to_string(id) + "/stat");
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const std::size_t begin = text.find('(');
  const std::size_t end = text.rfind(')');
  if (begin == std::string::npos || end == std::string::npos || end < begin) return std::nullopt;
  Process process{text.substr(begin + 1, end - begin - 1)};
  std::istringstream rest(text.substr(end + 1));
  char state = 0;
  if (!(rest >> state >> process.parent >> process.group)) return std::nullopt;
  return process;
}

std::vector<Ancestor> ancestors() {
  constexpr std::size_t kMax = 16;
  std::vector<Ancestor> found;
  pid_t group = ::getpgrp();
  pid_t next = ::getppid();
  while (next > 0 && found.size() < kMax) {
    const std::optional<Process> process = process_of(next);
    if (!process) break;
    found.push_back({process->name, process->group == group});
    group = process->group;
    next = process->parent;
  }
  return found;
}

}  // namespace

Launch launch_of_environment() {
  const auto by = [](const char* name, const char* text) {
    return Launch{std::atoi(text), std::string(name) + "=" + text};
  };
  for (const char* name : kSizeVariables) {
    if (const char* text = std::getenv(name)) return by(name, text);
  }
  // Slurm's PMIx plugin sets the rank alone.
  if (std::getenv("PMIX_RANK") != nullptr) {
    if (const char* text = std::getenv("SLURM_NTASKS")) return by("PMIX_RANK, SLURM_NTASKS", text);
  }
  return {};
}

bool is_launched(std::span<const Ancestor> ancestors) {
  for (const Ancestor& ancestor : ancestors) {
    const std::string_view name = ancestor.name;
    const auto begins = [name](std::string_view launcher) { return name.starts_with(launcher); };
    if (std::ranges::any_of(kLaunchers, begins)) return true;
    if (std::ranges::find(kWrappers, name) == std::end(kWrappers)) return false;
    if (!ancestor.same_group) return false;
  }
  return false;
}

bool is_launched(std::string& parent) {
  const std::vector<Ancestor> all = ancestors();
  parent = all.empty() ? "unknown" : all.front().name;
  return is_launched(all);
}

}  // namespace engram
