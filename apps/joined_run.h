// Commands that several processes run together.
#pragma once

#include <functional>

#include "protocol/work/ranks.h"

namespace engram::apps {

// Calls `body` with the processes that were started together with this one. If it throws and
// there are other processes, prints the message and ends them all.
void run_joined(const std::function<void(Ranks&)>& body);

}  // namespace engram::apps
