#include "apps/mpi_run.h"

#include "apps/output.h"

namespace engram::apps {

void with_mpi(const std::function<void(Ranks&)>& body) {
  const std::unique_ptr<Ranks> ranks = join_ranks();
  try {
    body(*ranks);
  } catch (const std::exception& error) {
    if (!ranks->is_single()) {
      print_error(error.what());
      ranks->abort();
    }
    throw;
  }
}

}  // namespace engram::apps
