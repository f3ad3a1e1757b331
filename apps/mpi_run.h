// Commands that run in one process or in several under MPI.
#pragma once

#include <functional>

#include "protocol/io/json.h"
#include "protocol/parallel/ranks.h"

namespace engram::apps {

// Calls `body` with the ranks of this run. If it throws and there are several, prints the message
// and ends them all. Throws Error if the mode is `on` and there are no ranks to join.
void with_mpi(MpiMode mode, const std::function<void(Ranks&)>& body);

// Broadcast of a document: gives every rank that of rank 0, null if it is none.
Json broadcast(Ranks& ranks, const Json& document);

}  // namespace engram::apps
