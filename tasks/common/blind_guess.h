// What the blind policy goes by: it acts as an agent would that remembers nothing.
#pragma once

#include "core/env/episode.h"
#include "core/env/task.h"
#include "core/math/random.h"

namespace engram::tasks {

// The numbers behind an agent's guess: the same ones in every step of an episode.
inline RandomStream blind_guess(const Bindings& engine, int env) {
  return {engine.stream_key(env), engine.state->episode[env], kPurposeBlindGuess};
}

}  // namespace engram::tasks
