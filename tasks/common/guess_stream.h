// Random stream of the blind expert, which acts as an agent would that remembers nothing.
#pragma once

#include "core/math/random.h"
#include "core/task/episode.h"
#include "core/task/task.h"

namespace engram::tasks {

// Numbers behind an agent's guess: the same ones in every step of an episode.
inline RandomStream guess_stream(const Bindings& engine, int env) {
  return {engine.policy_key(env), engine.state->episode[env], kPurposeBlindGuess};
}

}  // namespace engram::tasks
