#include "protocol/parallel/ranks.h"

#include <dlfcn.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>

#include "core/base/error.h"

namespace engram {
namespace {

// Variables that launchers set for their processes: Open MPI's own, and those of Slurm and others
// with PMI.
constexpr const char* kSizeVariables[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"};

struct Launch {
  int processes = 1;
  std::string variable;  // what says so, with its value
};

Launch launch() {
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

// The module beside the program, as in a build folder, where installations have it, or anywhere on
// the system's search path.
void* open_module() {
  constexpr const char* kName = "libengram_mpi.so";
  std::error_code ignored;
  const std::filesystem::path folder =
      std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path();
  void* module = nullptr;
  for (const auto& path : {folder / kName, folder / "../lib/engram" / kName}) {
    if (module == nullptr) module = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  }
  return module != nullptr ? module : ::dlopen(kName, RTLD_NOW | RTLD_LOCAL);
}

}  // namespace

// MPI is a library of its own, loaded only under a launcher. A single process does not need it.
std::unique_ptr<Ranks> join_ranks() {
  const Launch launched = launch();
  if (launched.processes <= 1) return std::make_unique<Ranks>();
  const auto refuse = [&](const std::string& reason) {
    throw Error(Error::kUnavailable,
                "the environment has " + launched.variable + ", but " + reason);
  };
  void* library = open_module();
  if (library == nullptr) {
    refuse(std::string("MPI is not part of this build or cannot be loaded: ") + ::dlerror());
  }
  using Join = Ranks* (*)();
  const auto join = reinterpret_cast<Join>(::dlsym(library, "engram_join_mpi"));
  if (join == nullptr) refuse("libengram_mpi.so is of another version");
  std::unique_ptr<Ranks> ranks(join());
  if (ranks->is_single()) refuse("MPI has found no other process");
  return ranks;
}

Bytes broadcast(Ranks& ranks, Bytes bytes) {
  if (ranks.is_root()) {
    for (int rank = 1; rank < ranks.size(); ++rank) ranks.send(rank, bytes);
    return bytes;
  }
  while (true) {
    if (auto message = ranks.receive()) return std::move(message->bytes);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace engram
