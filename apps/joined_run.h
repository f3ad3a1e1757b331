// Commands that several processes run together.
#pragma once

#include <functional>

#include "protocol/work/ranks.h"

namespace engram::apps {

// Calls `body` with the processes that were started together with this one. Where it throws and
// there are others, the message is told and all of them are ended.
void run_joined(const std::function<void(Ranks&)>& body);

}  // namespace engram::apps
