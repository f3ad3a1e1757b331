#include "protocol/eval/policies/external_policy.h"

#include <algorithm>
#include <cmath>

#include "core/base/join.h"
#include "core/observe/proprio.h"
#include "protocol/eval/policies/seed_commitment.h"

namespace engram {
namespace {

std::string shape_text(std::span<const std::int64_t> shape) {
  return "(" + join(shape, [](std::int64_t size) { return std::to_string(size); }) + ")";
}

template <class T>
void append(std::vector<T>& to, std::span<const T> values) {
  to.insert(to.end(), values.begin(), values.end());
}

}  // namespace

// --- reply ---

PolicyReply::PolicyReply(int count, int action_dim)
    : action_dim_(action_dim), chunks_(static_cast<std::size_t>(count)) {}

void PolicyReply::set(int row, std::span<const float> actions,
                      std::span<const std::int64_t> shape) {
  const auto refuse = [row](const std::string& what) {
    throw Error(Error::kInvalidArgument, "policy, row " + std::to_string(row) + ": " + what);
  };
  const std::string dim = std::to_string(action_dim_);
  if (row < 0 || row >= static_cast<int>(chunks_.size())) {
    refuse("given, 0 to " + std::to_string(chunks_.size() - 1) + " asked for");
  }
  const bool known_shape =
      shape.size() == 1 || shape.size() == 2 || (shape.size() == 3 && shape[0] == 1);
  if (!known_shape || shape.back() != action_dim_) {
    refuse("actions of shape " + shape_text(shape) + " given, (" + dim + "), (K, " + dim +
           ") or (1, K, " + dim + ") allowed");
  }
  const std::int64_t count = shape.size() == 1 ? 1 : shape[shape.size() - 2];
  if (count < 1) refuse("an empty chunk given, one action or more needed");
  if (static_cast<std::size_t>(count) * static_cast<std::size_t>(action_dim_) != actions.size()) {
    refuse(std::to_string(actions.size()) + " numbers given for shape " + shape_text(shape));
  }
  const auto bad =
      std::find_if_not(actions.begin(), actions.end(), [](float x) { return std::isfinite(x); });
  if (bad != actions.end()) {
    refuse("component " + std::to_string((bad - actions.begin()) % action_dim_) + " of action " +
           std::to_string((bad - actions.begin()) / action_dim_) + ": " + std::to_string(*bad) +
           " given, a finite number needed");
  }
  chunks_[static_cast<std::size_t>(row)].assign(actions.begin(), actions.end());
}

std::span<const float> PolicyReply::chunk(int row) const {
  const std::vector<float>& chunk = chunks_.at(static_cast<std::size_t>(row));
  if (chunk.empty()) {
    throw Error(Error::kInvalidArgument, "policy: no actions given for row " + std::to_string(row) +
                                             " of " + std::to_string(chunks_.size()));
  }
  return chunk;
}

void ExternalPolicy::choose(const ChoiceQuestion& /*question*/, ChoiceAnswer& /*answer*/) {
  throw Error(Error::kInternal, "this policy sends actions and names no answers");
}

// --- queues ---

EpisodeLabel label_episode(int episode, std::string_view env_id, std::uint64_t seed,
                           const std::string& key, bool tell) {
  return {episode, tell ? episode : opaque_number(key, env_id, seed), seed};
}

ChunkedPolicy::ChunkedPolicy(const Batch& batch, ExternalPolicy& policy, const WorkContext& context,
                             const ChunkedPolicyOptions& options)
    : batch_(batch),
      policy_(policy),
      context_(context),
      options_(options),
      states_(static_cast<std::size_t>(batch.num_envs())) {}

void ChunkedPolicy::start(int env, const EpisodeLabel& label) {
  states_[static_cast<std::size_t>(env)] = {label, true, ActionQueue(options_.latency), {}};
}

void ChunkedPolicy::replace_scene(int env, const EpisodeLabel& label) {
  EpisodeState& state = states_[static_cast<std::size_t>(env)];
  state.label = label;
  state.queue = ActionQueue(options_.latency);
}

void ChunkedPolicy::finish(int env) { states_[static_cast<std::size_t>(env)].label = {}; }

const EpisodeDigests& ChunkedPolicy::digests(int env) const {
  return states_[static_cast<std::size_t>(env)].digests;
}

void ChunkedPolicy::act(std::span<float> actions, std::span<std::uint8_t> commanded) {
  request();
  const auto dim = static_cast<std::size_t>(batch_.action_dim());
  std::fill(actions.begin(), actions.end(), 0.0F);
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const bool idle = states_[i].label.episode < 0;
    commanded[i] = idle || states_[i].queue.next(actions.subspan(i * dim, dim)) ? 1 : 0;
  }
}

// Fills the empty queues of all episodes under way.
void ChunkedPolicy::gather_rows() {
  rows_.clear();
  episodes_.clear();
  numbers_.clear();
  seeds_.clear();
  steps_.clear();
  first_.clear();
  instructions_.clear();
  proprio_.clear();
  rgb_.clear();
  state_.clear();
  const int num_envs = batch_.num_envs();
  for (int env = 0; env < num_envs; ++env) {
    EpisodeState& state = states_[static_cast<std::size_t>(env)];
    if (state.label.episode < 0 || !state.queue.empty()) continue;
    rows_.push_back(env);
    const PolicyView view = view_of(batch_, env);
    state.digests.add_question(view);
    episodes_.push_back(state.label.episode);
    numbers_.push_back(state.label.number);
    if (options_.tell_seeds) seeds_.push_back(state.label.seed);
    steps_.push_back(view.step);
    first_.push_back(state.first ? 1 : 0);
    state.first = false;
    instructions_.push_back(view.instruction);
    append(proprio_, view.proprio);
    append(rgb_, view.rgb);
    append(state_, view.state);
  }
}

void ChunkedPolicy::request() {
  gather_rows();
  if (rows_.empty()) return;

  PolicyRequest request;
  request.env_id = batch_.info().id;
  request.count = static_cast<int>(rows_.size());
  request.slots = rows_;
  request.episodes = episodes_;
  request.numbers = numbers_;
  request.seeds = seeds_;
  request.steps = steps_;
  request.first = first_;
  request.instructions = instructions_;
  request.proprio = proprio_;
  request.rgb = rgb_;
  request.state = state_;
  request.height = batch_.options().images.height;
  request.width = batch_.options().images.width;
  request.state_dim = state_.empty() ? 0 : batch_.state_dim();
  request.proprio_dim = proprio_dim(batch_.options().joint_proprio);
  request.max_slots = batch_.num_envs();
  request.policy_seed = options_.policy_seed;
  request.context = &context_;
  PolicyReply reply(request.count, batch_.action_dim());
  policy_.act(request, reply);
  for (int row = 0; row < request.count; ++row) {
    const std::span<const float> chunk = reply.chunk(row);
    const auto at = static_cast<std::size_t>(row);
    EpisodeState& state = states_[static_cast<std::size_t>(rows_[at])];
    state.queue.answer(chunk);
    state.digests.add_answer(steps_[at], chunk, batch_.action_dim());
    longest_chunk_ = std::max(longest_chunk_, static_cast<int>(chunk.size()) / batch_.action_dim());
  }
}

}  // namespace engram
