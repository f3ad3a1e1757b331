// engram: batched memory-manipulation tasks on CPUs. The C++ door.
//
//   auto env = engram::make("RememberColor9-VLA-v0", {.num_envs = 256, .seed = 7});
//   std::vector<float> actions(256 * env->action_dim());
//   env->reset();
//   env->act(engram::Policy::kOracle, actions);
//   env->step(actions);
//   env->observation();  // (256, state_dim) floats, in place until the next step
#pragma once

#include <memory>
#include <string_view>

#include "core/error.h"
#include "core/vector_env.h"
#include "tasks/registry.h"

namespace engram {

// A batch of environments of the task with that id. Throws Error: kUnknownId (with the nearest
// id), kUnavailable if its family is not part of this version, kInvalidArgument for a bad option.
std::unique_ptr<VectorEnv> make(std::string_view id, const EnvOptions& options = {});

// Version of the library, "0.1.0".
const char* version();

}  // namespace engram
