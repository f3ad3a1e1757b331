#include "protocol/eval/policies/episode_digests.h"

#include "core/batch/queries.h"
#include "protocol/io/chained_hash.h"
#include "protocol/make/rows.h"

namespace engram {
namespace {

template <class T>
void chain(std::uint64_t& hash, std::span<const T> piece) {
  if (!piece.empty()) hash = chain_hash(hash, piece);
}

void chain(std::uint64_t& hash, const std::int32_t& number) {
  chain(hash, std::span<const std::int32_t>(&number, 1));
}

}  // namespace

PolicyView view_of(const Batch& batch, int env) {
  PolicyView view;
  view.step = batch.state().elapsed[env];
  view.instruction = Queries(batch).instruction(env);
  view.proprio = row_of(batch.outputs().proprio, batch, env);
  if (batch.options().obs_mode == ObsMode::kRgb) view.rgb = row_of(batch.images().rgb, batch, env);
  view.state = row_of(batch.outputs().observation, batch, env);
  return view;
}

void EpisodeDigests::add_question(const PolicyView& view) {
  const bool first = observations == 0;
  chain(observations, view.step);
  chain(observations, std::span<const char>(view.instruction));
  chain(observations, view.proprio);
  chain(observations, view.rgb);
  chain(observations, view.state);
  if (first) first_observation = observations;
}

void EpisodeDigests::add_answer(std::int32_t step, std::span<const float> actions, int action_dim) {
  const bool first = answers == 0;
  const auto count = static_cast<std::int32_t>(actions.size()) / action_dim;
  chain(answers, step);
  chain(answers, count);
  chain(answers, actions);
  if (first) first_answer = answers;
}

}  // namespace engram
