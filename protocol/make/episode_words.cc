#include "protocol/make/episode_words.h"

#include "core/base/error.h"
#include "core/base/ieee_scope.h"
#include "core/batch/queries.h"
#include "protocol/io/json_values.h"

namespace engram {
JsonTable describe_words(const Batch& batch, int index) {
  const Queries queries(batch);
  std::vector<std::string> paraphrases = queries.paraphrases(index);
  const Annotator* annotator = queries.annotator();
  if (annotator == nullptr) {
    throw Error(Error::kUnavailable, batch.info().id + " has no words for its episodes");
  }
  const IeeeScope scope;
  const int object = annotator->object(index);
  const auto& props = batch.physics_model().props();
  const bool named = object >= 0 && static_cast<std::size_t>(object) < props.size();
  return {{"plan", to_list(annotator->plan(index))},
          {"subtask", annotator->subtask(index)},
          {"subtasks_done", annotator->subtasks_done(index)},
          {"memory", annotator->memory(index)},
          {"object", named ? Json(props[static_cast<std::size_t>(object)].name) : Json()},
          {"paraphrases", to_list(paraphrases)}};
}

}  // namespace engram
