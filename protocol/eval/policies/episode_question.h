// Questions of a batch's running episodes, for a caller who answers them while the episode is
// shown; the controller that carries the answers out is the blind policy (docs/choices.md).
#pragma once

#include <span>

#include "core/batch/batch.h"
#include "core/task/answer_controller.h"
#include "protocol/io/json.h"

namespace engram {

// All of them throw Error: kInvalidArgument for a task without choices, kBadState before the first
// reset.

// From now on the controller of an environment's episode waits for answers. For each episode anew.
void ask_questions(const Batch& batch, int index);
// {due, question, choices, least, most, repeats}. due: the controller cannot go on without an
// answer. The order of the choices is that of evaluations.
JsonTable describe_question(const Batch& batch, int index);
// Answers the question that is due, by indices of the choices as they are listed. Throws Error,
// kBadState if none is due, and kInvalidArgument, naming what is allowed, for another form.
void answer_question(const Batch& batch, int index, std::span<const int> choices);

}  // namespace engram
