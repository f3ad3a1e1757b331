#include "protocol/parallel/ranks.h"

#include <dlfcn.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>

#include "core/base/error.h"
#include "protocol/parallel/launcher.h"

namespace engram {
namespace {

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
std::unique_ptr<Ranks> join_ranks(MpiMode mode) {
  const Launch launched = launch_of_environment();
  const bool alone = mode == MpiMode::kAuto && launched.processes <= 1;
  if (mode == MpiMode::kOff || alone) return std::make_unique<Ranks>();
  const auto refuse = [&](const std::string& reason) {
    const std::string named = launched.variable.empty()
                                  ? "--mpi on given, "
                                  : "the environment has " + launched.variable + ", ";
    throw Error(Error::kUnavailable, named + "but " + reason);
  };
  // A program of a launcher's has ranks of its own; joining in its place would abort it, or wait.
  std::string parent;
  if (mode == MpiMode::kAuto && !is_launched(parent)) {
    refuse("'" + parent +
           "', which is no launcher, has started this process (--mpi on joins MPI nevertheless, "
           "--mpi off does without this message)");
  }
  void* library = open_module();
  if (library == nullptr) {
    refuse(std::string("MPI is not part of this build or cannot be loaded: ") + ::dlerror());
  }
  using Join = Ranks* (*)();
  const auto join = reinterpret_cast<Join>(::dlsym(library, "engram_join_mpi"));
  if (join == nullptr) refuse("libengram_mpi.so is of another version");
  std::unique_ptr<Ranks> ranks(join());
  if (ranks->is_single() && !launched.variable.empty() && launched.processes == 1) return ranks;
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
