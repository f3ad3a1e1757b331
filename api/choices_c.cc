// Questions of running episodes, in C.
#include <vector>

#include "api/c_batch.h"
#include "engram/engram_c.h"
#include "protocol/eval/policies/episode_question.h"

using engram::c::refuse_null;
using engram::c::with_env;

engram_status engram_ask(engram_env* env, int32_t index) {
  return with_env(env, [&](engram_env& of) {
    const auto [part, own_index] = of.batch->locate(index);
    engram::ask_questions(of.batch->part(part), own_index);
  });
}

engram_status engram_answer(engram_env* env, int32_t index, const int32_t* choices, size_t count) {
  if (choices == nullptr && count > 0) return refuse_null("choices");
  return with_env(env, [&](engram_env& of) {
    const auto [part, own_index] = of.batch->locate(index);
    engram::answer_question(of.batch->part(part), own_index, {choices, count});
  });
}
