// Commands that run in one process or in several under MPI.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "protocol/parallel/ranks.h"

namespace engram::apps {

// Calls `body` with the ranks of this run. If it throws and there are several, prints the message
// and ends them all.
void with_mpi(const std::function<void(Ranks&)>& body);

// Definitions of tasks by content, for the root to broadcast.
Bytes definitions_message(const std::vector<std::string>& ids);
// Throws Error (kInvalidArgument) if this rank defines one of them in another way than the root.
void require_definitions_of_root(const std::vector<std::string>& ids, const Bytes& message);

}  // namespace engram::apps
