#include "protocol/eval/probe/question.h"

#include <algorithm>
#include <array>

#include "core/batch/queries.h"
#include "core/batch/snapshot.h"
#include "protocol/eval/policies/episode_digests.h"
#include "protocol/make/rows.h"
#include "tasks/registry.h"

namespace engram {
namespace {

// Control steps in which the hand comes to rest once it needs the answer. Where it stops short, the
// way to one place leads past another.
constexpr int kHandSettles = 8;

template <class T>
void append(std::vector<std::byte>& bytes, std::span<const T> values) {
  const auto raw = std::as_bytes(values);
  bytes.insert(bytes.end(), raw.begin(), raw.end());
}

std::unique_ptr<Batch> make_single(std::string_view id, MakeOptions options) {
  options.num_envs = 1;
  options.threads = 1;
  options.auto_reset = AutoReset::kOff;
  return make(id, options);
}

const MemoryFacts& facts_of(const Batch& batch) {
  return require_entry(batch.info().id).definition->memory;
}

}  // namespace

CuePolicy::CuePolicy(Batch& batch)
    : batch_(batch),
      controller_(facts_of(batch).cue_by_hand ? Queries(batch).choices() : nullptr),
      script_(batch, controller_ != nullptr ? Policy::kBlind : Policy::kOracle) {}

// The controller gets no answer: it stops where it would need to know.
void CuePolicy::begin(int env) const {
  if (controller_ != nullptr) controller_->await_answers(env);
}

void CuePolicy::end(int env) const {
  if (controller_ != nullptr) controller_->discard_answers(env);
}

bool CuePolicy::awaits_cue(int env) const {
  if (controller_ != nullptr) return !controller_->is_choice_due(env);
  return Queries(batch_).cue_end(env) >= batch_.info().horizon;
}

void CuePolicy::act(std::span<const int> envs, std::span<float> actions,
                    std::span<std::uint8_t> commanded) {
  bool any = false;
  for (const int env : envs) {
    // The hand goes on to where it would ask from.
    const bool acts = uses_controller() || awaits_cue(env);
    commanded[static_cast<std::size_t>(env)] = acts ? 1 : 0;
    any |= acts;
  }
  if (!any) return;
  // All of them: the scripts of tasks with BatchTask have no ranges.
  script_actions_.resize(actions.size());
  script_.act(script_actions_);
  for (const int env : envs) {
    if (commanded[static_cast<std::size_t>(env)] == 0) continue;
    const std::span<const float> row = row_of(std::span<const float>(script_actions_), batch_, env);
    std::ranges::copy(row, actions.begin() + env * static_cast<std::ptrdiff_t>(row.size()));
  }
}

std::vector<std::byte> visible_state(const Batch& batch, int env) {
  std::vector<std::byte> bytes;
  const PolicyView view = view_of(batch, env);
  append(bytes, std::span<const std::int32_t>(&view.step, 1));
  append(bytes, std::span<const char>(view.instruction));
  append(bytes, view.proprio);
  append(bytes, view.rgb);
  append(bytes, view.state);
  std::vector<float> qpos(static_cast<std::size_t>(batch.num_envs()) * kRobotJoints);
  std::vector<float> qvel(qpos.size());
  Queries(batch).robot_state(qpos, qvel, {});
  append(bytes, row_of(std::span<const float>(qpos), batch, env));
  append(bytes, row_of(std::span<const float>(qvel), batch, env));
  const ColumnStore& columns = BatchAccess::data(batch).outputs;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const ColumnView output = batch.output(columns[i].field->name);
    if (output.field->privileged) continue;
    const auto width = static_cast<std::size_t>(output.field->width) * size_of(output.field->dtype);
    append(bytes, std::span<const std::byte>(output.row(env), width));
  }
  return bytes;
}

Lookahead::Lookahead(std::string_view id, const MakeOptions& options)
    : batch_(make_single(id, options)),
      cue_policy_(*batch_),
      actions_(static_cast<std::size_t>(batch_->action_dim())) {}

void Lookahead::begin(const EpisodeDraw& draw) {
  const std::array<std::uint64_t, 1> seeds = {draw.seed};
  batch_->reset({.mask = {}, .seeds = seeds, .pins = &draw.pins});
  cue_policy_.begin(0);
}

void Lookahead::step() {
  constexpr std::array kSlots = {0};
  std::array<std::uint8_t, 1> commanded = {1};
  cue_policy_.act(kSlots, actions_, commanded);
  batch_->step(actions_, commanded);
}

bool Lookahead::awaits_cue(const EpisodeDraw& draw) {
  begin(draw);
  return cue_policy_.awaits_cue(0);
}

int Lookahead::cue_end(const EpisodeDraw& draw) {
  begin(draw);
  while (cue_policy_.awaits_cue(0) && batch_->state().finished[0] == 0) step();
  if (cue_policy_.awaits_cue(0)) return -1;
  if (cue_policy_.uses_controller()) return batch_->state().elapsed[0] + kHandSettles;
  const int end = Queries(*batch_).cue_end(0);
  return end < 1 ? -1 : end;
}

std::vector<double> Lookahead::right_answer(const EpisodeDraw& draw) {
  begin(draw);
  const TaskInfo& info = batch_->info();
  std::vector<double> answer;
  if (info.oracle_dim == 0) return answer;
  const ColumnView output = batch_->output("oracle_info");
  for (int i = 0; i < info.oracle_dim; ++i) {
    const std::byte* row = output.row(0);
    answer.push_back(info.oracle_is_real
                         ? static_cast<double>(reinterpret_cast<const float*>(row)[i])
                         : static_cast<double>(reinterpret_cast<const std::int32_t*>(row)[i]));
  }
  return answer;
}

std::shared_ptr<const std::vector<std::byte>> Lookahead::scene_at(const EpisodeDraw& draw,
                                                                  int question) {
  begin(draw);
  while (batch_->state().elapsed[0] < question && batch_->state().finished[0] == 0) step();
  return std::make_shared<const std::vector<std::byte>>(Snapshotter(*batch_).save(0));
}

}  // namespace engram
