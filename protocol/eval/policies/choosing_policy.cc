#include "protocol/eval/policies/choosing_policy.h"

#include <algorithm>

#include "core/batch/queries.h"

namespace engram {
namespace {

template <class T>
void append(std::vector<T>& to, std::span<const T> values) {
  to.insert(to.end(), values.begin(), values.end());
}

// The values of frame `index` of `count`.
template <class T>
std::span<const T> frame_of(const std::vector<T>& all, std::size_t index, std::size_t count) {
  const std::size_t width = all.size() / count;
  return std::span(all).subspan(index * width, width);
}

}  // namespace

ChoosingPolicy::ChoosingPolicy(Batch& env, ExternalPolicy& policy, const WorkContext& context,
                               const ChoosingPolicyOptions& options)
    : env_(env),
      choices_(*Queries(env).choices()),
      form_(choices_.choice_form()),
      hand_(env, Policy::kBlind),
      policy_(policy),
      context_(context),
      options_(options),
      slots_(static_cast<std::size_t>(env.num_envs())) {
  if (observes_objects(env.options().obs_mode)) words_.emplace(env);
}

void ChoosingPolicy::start(int slot, const EpisodeLabel& label) {
  Slot& fresh = slots_[static_cast<std::size_t>(slot)];
  fresh = {};
  fresh.label = label;
  choices_.await_choices(slot);
}

// The frames so far are what it remembers.
void ChoosingPolicy::go_on(int slot, const EpisodeLabel& label) {
  slots_[static_cast<std::size_t>(slot)].label = label;
}

void ChoosingPolicy::finish(int slot) {
  slots_[static_cast<std::size_t>(slot)].label = {};
  choices_.forget_choices(slot);
}

const EpisodeDigests& ChoosingPolicy::digests(int slot) const {
  return slots_[static_cast<std::size_t>(slot)].digests;
}

void ChoosingPolicy::act(std::span<float> actions, std::span<std::uint8_t> commanded) {
  for (int env = 0; env < env_.num_envs(); ++env) {
    Slot& slot = slots_[static_cast<std::size_t>(env)];
    if (slot.label.episode < 0 || slot.questions >= form_.questions) continue;
    const bool due = choices_.is_choice_due(env);
    observe(env, slot, due);
    if (due) ask(env, slot);
  }
  hand_.act(actions);
  std::ranges::fill(commanded, std::uint8_t{1});
}

// --- frames ---

void ChoosingPolicy::observe(int env, Slot& slot, bool due) const {
  if (!due && env_.state().elapsed[env] % options_.stride != 0) return;
  const PolicyView view = view_of(env_, env);
  Frames& frames = slot.frames;
  std::string text = words_ ? words_->describe(view.state) : std::string();
  if (!due && is_as_before(frames, view, text)) return;
  frames.steps.push_back(view.step);
  append(frames.proprio, view.proprio);
  append(frames.rgb, view.rgb);
  append(frames.state, view.state);
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

void ChoosingPolicy::ask(int env, Slot& slot) {
  const std::vector<std::string> items = choices_.choice_items(env);
  const std::vector<int> order =
      choice_order(form_, env_.info().id, slot.label.seed, slot.questions, items.size());
  ChoiceQuestion question;
  question.env_id = env_.info().id;
  question.slot = env;
  question.episode = slot.label.episode;
  question.number = slot.label.number;
  if (options_.tell_seeds) question.seed = slot.label.seed;
  question.step = slot.frames.steps.back();
  question.index = slot.questions++;
  question.instruction = Queries(env_).instruction(env);
  question.form = form_;
  for (const int key : order) question.choices.push_back(items[static_cast<std::size_t>(key)]);
  question.steps = slot.frames.steps;
  question.proprio = slot.frames.proprio;
  question.rgb = slot.frames.rgb;
  question.state = slot.frames.state;
  question.texts = slot.frames.texts;
  question.height = env_.options().images.height;
  question.width = env_.options().images.width;
  question.state_dim = question.state.empty() ? 0 : env_.state_dim();
  question.proprio_dim = env_.proprio_dim();
  question.max_slots = env_.num_envs();
  question.policy_seed = options_.policy_seed;
  question.context = &context_;
  ChoiceAnswer answer(question);
  policy_.choose(question, answer);

  std::vector<int> keys;
  for (const int index : answer.indices()) keys.push_back(order[static_cast<std::size_t>(index)]);
  choices_.choose(env, keys);
  const std::size_t count = slot.frames.steps.size();
  for (std::size_t i = 0; i < count; ++i) {
    slot.digests.add_question({.step = slot.frames.steps[i],
                               .instruction = question.instruction,
                               .proprio = frame_of(slot.frames.proprio, i, count),
                               .rgb = frame_of(slot.frames.rgb, i, count),
                               .state = frame_of(slot.frames.state, i, count)});
  }
  const std::vector<float> named(keys.begin(), keys.end());
  slot.digests.add_answer(question.step, named, 1);
  slot.frames = {};
}

std::unique_ptr<EpisodeActor> make_external_actor(Batch& env, ExternalPolicy& policy,
                                                  const WorkContext& context,
                                                  const ChunkedPolicyOptions& options, int stride) {
  if (stride == 0) return std::make_unique<ChunkedPolicy>(env, policy, context, options);
  return std::make_unique<ChoosingPolicy>(
      env, policy, context, ChoosingPolicyOptions{options.tell_seeds, options.policy_seed, stride});
}

}  // namespace engram
