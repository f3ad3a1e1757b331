#include "core/batch/batch.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/ieee_scope.h"
#include "core/base/join.h"
#include "core/batch/step_loop.h"
#include "core/threads/processors.h"

namespace engram {
namespace {

[[noreturn]] void refuse_mixed(const Batch& one, const Batch& other, const char* what,
                               const std::string& of_one, const std::string& of_other) {
  throw Error(Error::kInvalidArgument, std::string(what) + ": " + of_one + " of " + one.info().id +
                                           " and " + of_other + " of " + other.info().id +
                                           " given, one for all tasks needed");
}

void require_alike(const Batch& one, const Batch& other) {
  const BatchOptions& a = one.options();
  const BatchOptions& b = other.options();
  if (a.control_mode != b.control_mode) {
    refuse_mixed(one, other, "control mode", name_of(*a.control_mode), name_of(*b.control_mode));
  }
  if (a.obs_mode != b.obs_mode) {
    refuse_mixed(one, other, "observation mode", name_of(a.obs_mode), name_of(b.obs_mode));
  }
  if (a.auto_reset != b.auto_reset) {
    refuse_mixed(one, other, "auto-reset", name_of(a.auto_reset), name_of(b.auto_reset));
  }
}

// Whole blocks of lanes, and several segments for each thread.
int segment_length(int lanes, int num_envs, int threads) {
  const int share = std::min(num_envs / (threads * 8), 16);
  return std::max(lanes, share - share % lanes);
}

void require_finite(std::span<const float> actions, std::size_t dim) {
  const auto bad =
      std::ranges::find_if_not(actions, [](float value) { return std::isfinite(value); });
  if (bad == actions.end()) return;
  const auto index = static_cast<std::size_t>(bad - actions.begin());
  throw Error(Error::kInvalidArgument, "action of environment " + std::to_string(index / dim) +
                                           ", component " + std::to_string(index % dim) + ": " +
                                           std::to_string(*bad) + " given, a finite number needed");
}

// Values of a part's environments; null and empty stay so.
template <class T>
std::span<T> rows_of(std::span<T> all, const BatchData& part) {
  return all.empty() ? all : all.subspan(at(part.first_env), at(part.num_envs()));
}

template <class T>
std::span<const T> values(const std::vector<OutputArray>& arrays, std::string_view name) {
  const OutputArray* const array = find_array(arrays, name);
  if (array == nullptr || array->field.width == 0) return {};
  return {reinterpret_cast<const T*>(array->data),
          at(static_cast<int>(array->shape.front())) * at(array->field.width)};
}

ColumnView named(const ColumnStore& store, std::string_view name) {
  const ColumnView view = store.find(name);
  if (view.field != nullptr) return view;
  std::vector<std::string_view> names;
  names.reserve(store.size());
  for (std::size_t i = 0; i < store.size(); ++i) names.push_back(store[i].field->name);
  throw Error(Error::kUnknownId,
              "no output named '" + std::string(name) + "'; this task has: " + join(names));
}

}  // namespace

Batch::Batch(std::unique_ptr<Task> task, const BatchOptions& options, RendererFactory renderers) {
  const IeeeScope scope;
  data_ = std::make_unique<BatchData>(std::move(task), options, std::move(renderers));
  num_envs_ = data_->num_envs();
  parts_.emplace_back().batch = this;
  pool_.emplace(data_->options.threads, data_->range_unit());
  BatchData* const data = data_.get();
  arrays_.emplace(std::span(&data, 1), false);
  find_outputs();
}

Batch::Batch(std::vector<std::unique_ptr<Batch>> parts, int threads) {
  if (parts.empty()) throw Error(Error::kInvalidArgument, "no task given, at least one needed");
  if (threads == 0) threads = std::min(available_processors(), kMaxThreads);
  std::vector<BatchData*> data;
  for (std::unique_ptr<Batch>& given : parts) {
    if (!parts_.empty()) require_alike(part(0), *given);
    Part& added = parts_.emplace_back();
    added.batch = given.get();
    added.data().first_env = num_envs_;
    added.owned = std::move(given);
    added.busy = std::make_unique<std::atomic<bool>[]>(at(added.batch->threads()));
    num_envs_ += added.batch->num_envs();
    data.push_back(&added.data());
  }
  for (int i = 0; i < num_parts(); ++i) {
    if (data[at(i)]->batch_task != nullptr) continue;  // which shares its own work
    const int envs = data[at(i)]->num_envs();
    const int length = segment_length(data[at(i)]->simulator->lanes(), num_envs_, threads);
    for (int begin = 0; begin < envs; begin += length) {
      segments_.push_back({i, {begin, std::min(begin + length, envs)}});
    }
  }
  pool_.emplace(std::clamp(static_cast<int>(segments_.size()), 1, threads));
  arrays_.emplace(data, true);
  find_outputs();
}

Batch::~Batch() = default;

void Batch::find_outputs() {
  const std::vector<OutputArray>& now = arrays_->now();
  outputs_ = {.observation = values<float>(now, "observation"),
              .proprio = values<float>(now, "proprio"),
              .reward = values<float>(now, "reward"),
              .terminated = values<std::uint8_t>(now, "terminated"),
              .truncated = values<std::uint8_t>(now, "truncated"),
              .success = values<std::uint8_t>(now, "success"),
              .unstable = values<std::uint8_t>(now, "unstable"),
              .final_mask = values<std::uint8_t>(now, "final_mask")};
}

BatchData& Batch::data() const {
  if (data_ != nullptr) return *data_;
  throw Error(Error::kBadState, "this batch has several tasks, one needed; ask its parts");
}

std::pair<int, int> Batch::locate(int env) const {
  if (env < 0 || env >= num_envs_) {
    throw Error(Error::kInvalidArgument, "environment " + std::to_string(env) + " given, 0 to " +
                                             std::to_string(num_envs_ - 1) + " allowed");
  }
  if (data_ != nullptr) return {0, env};  // also where it is a part of a larger one
  const auto first_env = [](const Part& part) { return part.data().first_env; };
  const auto after = std::ranges::upper_bound(parts_, env, {}, first_env);
  return {static_cast<int>(after - parts_.begin()) - 1, env - first_env(after[-1])};
}

int Batch::state_dim() const {
  if (data_ == nullptr) return find_array(arrays_->now(), "observation")->field.width;
  return data_->objects ? data_->objects->width() : data_->observation.width();
}

int Batch::horizon() const {
  int longest = 0;
  for (const Part& part : parts_) longest = std::max(longest, part.data().info().horizon);
  return longest;
}

// Calls loop(data, caller) for a task with BatchTask.
template <class Loop>
void Batch::run_listed(Loop&& loop) {
  const auto run = [this](auto&& stage) {
    pool_->run(num_envs_, data_->options.chunk, [&](int worker, int begin, int end) {
      stage(worker, Range{begin, end});
    });
  };
  data_->interrupted = true;  // unless the end is reached
  loop(*data_, ListCaller(*data_, run));
  data_->interrupted = false;
}

void Batch::reset(const ResetRequest& request) {
  const IeeeScope scope;
  if (!request.mask.empty()) require_length("reset mask", request.mask.size(), at(num_envs_));
  if (!request.seeds.empty()) require_length("reset seeds", request.seeds.size(), at(num_envs_));
  std::vector<std::optional<CheckedReset>> resets(parts_.size());
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const BatchData& data = parts_[i].data();
    ResetRequest own = request;
    own.mask = rows_of(request.mask, data);
    own.seeds = rows_of(request.seeds, data);
    const bool concerned = !is_common() || own.mask.empty() ||
                           std::ranges::any_of(own.mask, [](auto chosen) { return chosen != 0; });
    if (concerned) resets[i] = data.checked_reset(own);
  }
  for_ranges([&](int part, int worker, Range envs) {
    BatchData& data = parts_[at(part)].data();
    if (resets[at(part)]) run_reset(data, RangeCaller(data, worker, envs), *resets[at(part)]);
  });
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (!resets[i]) continue;
    if (parts_[i].data().batch_task != nullptr) {
      parts_[i].batch->run_listed(
          [&](BatchData& data, auto caller) { run_reset(data, caller, *resets[i]); });
    }
    parts_[i].data().started = true;
  }
}

void Batch::check_actions(std::span<const float> actions) const {
  for (const Part& part : parts_) part.data().require_started("step");
  const std::size_t dim = at(action_dim());
  require_length("actions", actions.size(), at(num_envs_) * dim);
  require_finite(actions, dim);
  for (const Part& part : parts_) part.data().refuse_ended();
}

void Batch::step(std::span<const float> actions, std::span<const std::uint8_t> commanded) {
  check_actions(actions);
  if (!commanded.empty()) require_length("commanded", commanded.size(), at(num_envs_));
  step_all(actions.data(), commanded);
}

void Batch::step_no_action() {
  for (const Part& part : parts_) {
    part.data().require_started("step");
    part.data().refuse_ended();
  }
  step_all(nullptr, {});
}

void Batch::step_all(const float* actions, std::span<const std::uint8_t> commanded) {
  const IeeeScope scope;
  arrays_->next_buffer();
  const auto actions_of = [&](const Part& part) {
    StepActions own = {nullptr, rows_of(commanded, part.data())};
    if (actions != nullptr) own.values = actions + at(part.data().first_env) * at(action_dim());
    return own;
  };
  for_ranges([&](int part, int worker, Range envs) {
    BatchData& data = parts_[at(part)].data();
    run_step(data, RangeCaller(data, worker, envs), actions_of(parts_[at(part)]));
  });
  for (const Part& part : parts_) {
    if (part.data().batch_task == nullptr) continue;
    part.batch->run_listed(
        [&](BatchData& data, auto caller) { run_step(data, caller, actions_of(part)); });
  }
}

void Batch::write_to(std::span<const std::vector<OutputTarget>> turns) {
  if (std::ranges::any_of(parts_, [](const Part& part) { return part.data().started; })) {
    throw Error(Error::kBadState,
                "arrays for outputs given after the first reset; give them before");
  }
  arrays_->write_to(turns);
}

ObservedImages Batch::images() const {
  const ImageBatch* const batch = data().images.get();
  if (batch == nullptr) return {};
  ObservedImages images = {
      batch->rgb().now(), batch->depth().now(), batch->segmentation().now(), {}};
  if (!images.segmentation.empty()) images.segmentation_names = batch->segments();
  return images;
}

ColumnView Batch::output(std::string_view name) const {
  if (data().objects && name == BatchData::kObservation) return data().objects->rows();
  return named(data().outputs, name);
}

ColumnView Batch::final_output(std::string_view name) const {
  if (data().objects && name == BatchData::kObservation) return data().objects->final_rows();
  return named(data().final_outputs, name);
}

}  // namespace engram
