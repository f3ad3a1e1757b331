#include "protocol/eval/policies/choosing_policy.h"

#include <algorithm>

#include "core/batch/queries.h"
#include "core/observe/proprio.h"

namespace engram {
namespace {

template <class T>
void append_values(std::vector<T>& to, std::span<const T> values) {
  to.insert(to.end(), values.begin(), values.end());
}

// The values of frame `index` of `count`.
template <class T>
std::span<const T> frame_of(const std::vector<T>& all, std::size_t index, std::size_t count) {
  const std::size_t width = all.size() / count;
  return std::span(all).subspan(index * width, width);
}

}  // namespace

ChoosingPolicy::ChoosingPolicy(Batch& batch, ExternalPolicy& policy, const WorkContext& context,
                               const ChoosingPolicyOptions& options)
    : batch_(batch),
      controller_(*Queries(batch).choices()),
      form_(controller_.choice_form()),
      script_(batch, Policy::kBlind),
      policy_(policy),
      context_(context),
      options_(options),
      states_(static_cast<std::size_t>(batch.num_envs())) {
  if (observes_objects(batch.options().obs_mode)) words_.emplace(batch);
}

void ChoosingPolicy::start(int env, const EpisodeLabel& label) {
  EpisodeState& fresh = states_[static_cast<std::size_t>(env)];
  fresh = {};
  fresh.label = label;
  controller_.await_answers(env);
}

// The frames so far are what it remembers.
void ChoosingPolicy::replace_scene(int env, const EpisodeLabel& label) {
  states_[static_cast<std::size_t>(env)].label = label;
}

void ChoosingPolicy::finish(int env) {
  states_[static_cast<std::size_t>(env)].label = {};
  controller_.discard_answers(env);
}

const EpisodeDigests& ChoosingPolicy::digests(int env) const {
  return states_[static_cast<std::size_t>(env)].digests;
}

void ChoosingPolicy::act(std::span<float> actions, std::span<std::uint8_t> commanded) {
  for (int env = 0; env < batch_.num_envs(); ++env) {
    EpisodeState& state = states_[static_cast<std::size_t>(env)];
    if (state.label.episode < 0 || state.questions >= form_.questions) continue;
    const bool due = controller_.is_choice_due(env);
    observe(env, state, due);
    if (due) ask(env, state);
  }
  script_.act(actions);
  std::ranges::fill(commanded, std::uint8_t{1});
}

// --- frames ---

void ChoosingPolicy::observe(int env, EpisodeState& state, bool due) const {
  if (!due && batch_.state().elapsed[env] % options_.stride != 0) return;
  const PolicyView view = view_of(batch_, env);
  Frames& frames = state.frames;
  std::string text = words_ ? words_->describe(view.state) : std::string();
  if (!due && is_as_before(frames, view, text)) return;
  frames.steps.push_back(view.step);
  append_values(frames.proprio, view.proprio);
  append_values(frames.rgb, view.rgb);
  append_values(frames.state, view.state);
  if (words_) frames.texts.push_back(std::move(text));
}

bool ChoosingPolicy::is_as_before(const Frames& frames, const PolicyView& view,
                                  const std::string& text) const {
  if (frames.steps.empty()) return false;
  if (words_) return text == frames.texts.back();
  const std::size_t count = frames.steps.size();
  return !view.rgb.empty() && std::ranges::equal(view.rgb, frame_of(frames.rgb, count - 1, count));
}

// --- questions ---

void ChoosingPolicy::ask(int env, EpisodeState& state) {
  const std::vector<std::string> items = controller_.choice_items(env);
  const std::vector<int> order =
      choice_order(form_, batch_.info().id, state.label.seed, state.questions, items.size());
  ChoiceQuestion question;
  question.env_id = batch_.info().id;
  question.slot = env;
  question.episode = state.label.episode;
  question.number = state.label.number;
  if (options_.tell_seeds) question.seed = state.label.seed;
  question.step = state.frames.steps.back();
  question.index = state.questions++;
  question.instruction = Queries(batch_).instruction(env);
  question.form = form_;
  for (const int key : order) question.choices.push_back(items[static_cast<std::size_t>(key)]);
  question.steps = state.frames.steps;
  question.proprio = state.frames.proprio;
  question.rgb = state.frames.rgb;
  question.state = state.frames.state;
  question.texts = state.frames.texts;
  question.height = batch_.options().images.height;
  question.width = batch_.options().images.width;
  question.state_dim = question.state.empty() ? 0 : batch_.state_dim();
  question.proprio_dim = proprio_dim(batch_.options().joint_proprio);
  question.max_slots = batch_.num_envs();
  question.policy_seed = options_.policy_seed;
  question.context = &context_;
  ChoiceAnswer answer(question);
  policy_.choose(question, answer);

  std::vector<int> keys;
  for (const int index : answer.indices()) keys.push_back(order[static_cast<std::size_t>(index)]);
  controller_.choose(env, keys);
  const std::size_t count = state.frames.steps.size();
  for (std::size_t i = 0; i < count; ++i) {
    state.digests.add_question({.step = state.frames.steps[i],
                                .instruction = question.instruction,
                                .proprio = frame_of(state.frames.proprio, i, count),
                                .rgb = frame_of(state.frames.rgb, i, count),
                                .state = frame_of(state.frames.state, i, count)});
  }
  const std::vector<float> named(keys.begin(), keys.end());
  state.digests.add_answer(question.step, named, 1);
  state.frames = {};
}

std::unique_ptr<EpisodeActor> make_external_actor(Batch& batch, ExternalPolicy& policy,
                                                  const WorkContext& context,
                                                  const ChunkedPolicyOptions& options, int stride) {
  if (stride == 0) return std::make_unique<ChunkedPolicy>(batch, policy, context, options);
  return std::make_unique<ChoosingPolicy>(
      batch, policy, context,
      ChoosingPolicyOptions{options.tell_seeds, options.policy_seed, stride});
}

}  // namespace engram
