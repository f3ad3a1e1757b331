// Everything that users can know of a task before they run it.
#pragma once

#include <string>

#include "apps/json.h"
#include "engram/engram.h"

namespace engram::apps {

// One object: registry, actions, draws, observation, outputs, constants, rewards, phases, props.
Json describe_task(const VectorEnv& env);

// The same for people, in sections.
std::string describe_in_words(const Json& task);

}  // namespace engram::apps
