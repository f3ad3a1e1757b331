#include "protocol/parallel/ranks.h"

#include <dlfcn.h>

#include <chrono>
#include <string>
#include <thread>

#include "core/base/error.h"
#include "core/base/module.h"
#include "protocol/parallel/launcher.h"

namespace engram {

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
  using Join = Ranks* (*)();
  const auto join = reinterpret_cast<Join>(module_function("libengram_mpi.so", "engram_join_mpi"));
  if (join == nullptr) {
    refuse(std::string("MPI is not part of this build or cannot be loaded: ") + ::dlerror());
  }
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
