#include "protocol/training/preset.h"

#include <algorithm>
#include <string>

#include "core/base/error.h"
#include "core/base/index.h"
#include "core/base/join.h"

namespace engram::training {
namespace {

void require(bool good, const char* what, double given, const char* needed) {
  if (good) return;
  throw Error(Error::kInvalidArgument,
              std::string(what) + ": " + shortest(given) + " given, " + needed + " needed");
}

constexpr double kMaxWeight = 1e6;

bool is_weight(double value) { return value >= 0 && value <= kMaxWeight; }

const Options& checked(const Options& options) {
  constexpr const char* kWeights = "0 to 1e6";
  require(options.gamma > 0 && options.gamma <= 1, "gamma", options.gamma, "more than 0, up to 1");
  require(options.smoothing >= 0 && options.smoothing < 1, "smoothing", options.smoothing,
          "0 to less than 1");
  require(is_weight(options.potential), "potential", options.potential, kWeights);
  require(is_weight(options.still), "still", options.still, kWeights);
  require(is_weight(options.bonus), "bonus", options.bonus, kWeights);
  return options;
}

// Success pays the rest of the horizon, and later steps nothing.
Batch& ending_at_success(Batch& batch) {
  for (int i = 0; i < batch.num_parts(); ++i) {
    const Batch& part = batch.part(i);
    const bool own = part.info().termination != Termination::kNever;
    if (part.options().terminate_on_success.value_or(own)) continue;
    throw Error(Error::kInvalidArgument, "terminate_on_success: off given for " + part.info().id +
                                             ", on needed by the preset for training");
  }
  return batch;
}

template <class T>
const T* data_of(const std::vector<OutputArray>& arrays, const char* name) {
  const OutputArray* const array = find_array(arrays, name);
  return array != nullptr ? reinterpret_cast<const T*>(array->data) : nullptr;
}

Column<const float> rows_of(const std::vector<OutputArray>& arrays, const char* name) {
  const OutputArray* const array = find_array(arrays, name);
  return {data_of<float>(arrays, name), array != nullptr ? array->field.width : 0};
}

}  // namespace

Preset::Preset(Batch& batch, const Options& options)
    : batch_(ending_at_success(batch)),
      options_(checked(options)),
      auto_reset_(batch.part(0).options().auto_reset),
      shaping_(batch, options),
      now_(source_of(batch.output_arrays().now())),
      last_(source_of(batch.output_arrays().finals())),
      terminated_(data_of<std::uint8_t>(batch.output_arrays().now(), "terminated")),
      truncated_(data_of<std::uint8_t>(batch.output_arrays().now(), "truncated")) {
  for (int i = 0; i < batch.num_parts(); ++i) {
    horizons_.insert(horizons_.end(), at(batch.part(i).num_envs()), batch.part(i).info().horizon);
  }
  set_action_space();
  set_rows();
  const std::size_t num_envs = at(batch.num_envs());
  over_.resize(num_envs);
  reward_.resize(num_envs);
  observation_.resize(num_envs * at(dim_));
  if (auto_reset_ == AutoReset::kSameStep) final_observation_.resize(observation_.size());
}

Preset::Source Preset::source_of(const std::vector<OutputArray>& arrays) {
  Source source;
  source.rows = rows_of(arrays, "observation");
  source.reward_terms = rows_of(arrays, "reward_dict");
  source.reward = data_of<float>(arrays, "reward");
  source.success = data_of<std::uint8_t>(arrays, "success");
  source.success_once = data_of<std::uint8_t>(arrays, "success_once");
  source.elapsed = data_of<std::int32_t>(arrays, "elapsed_steps");
  return source;
}

void Preset::set_action_space() {
  action_space_ = batch_.action_space();
  const std::size_t dim = action_space_.low.size();
  scales_.assign(dim, static_cast<float>(kOtherScale));
  if (batch_.part(0).options().control_mode == ControlMode::kPdEeDeltaPose) {
    std::ranges::transform(kPoseScale, scales_.begin(),
                           [](double scale) { return static_cast<float>(scale); });
  }
  for (std::size_t i = 0; options_.scale_actions && i < dim; ++i) {
    action_space_.low[i] /= scales_[i];
    action_space_.high[i] /= scales_[i];
  }
  const std::size_t count = at(batch_.num_envs()) * dim;
  for (std::vector<float>* values : {&given_, &smoothed_, &past_, &scaled_}) values->resize(count);
}

void Preset::set_rows() {
  const std::vector<RangedField>& fields = batch_.output_arrays().row_fields();
  if (fields.empty()) return;
  dim_ = now_.rows.width();
  if (options_.scale_observations) {
    if (observes_objects(batch_.part(0).options().obs_mode)) {
      dim_ = objects_.emplace(fields, batch_.num_envs()).dim();
    } else {
      dim_ = states_.emplace(fields, batch_.horizon()).dim();
    }
  }
  if (options_.time_left) ++dim_;
}

void Preset::reset(const ResetRequest& request) {
  const int num_envs = batch_.num_envs();
  const bool masked = request.mask.size() == at(num_envs);
  for (int env = 0; !started_ && masked && env < num_envs; ++env) {
    if (request.selects(env)) continue;
    throw Error(Error::kBadState, "first reset with environment " + std::to_string(env) +
                                      " masked out; this one must reset all");
  }
  batch_.reset(request);
  started_ = true;
  for (int env = 0; env < num_envs; ++env) {
    if (!request.selects(env)) continue;
    over_[at(env)] = 0;
    reward_[at(env)] = 0;
    begin(env);
    write_row(now_, env, true, observation_.data());
  }
}

void Preset::step(std::span<const float> actions) {
  if (!started_) throw Error(Error::kBadState, "step before the first reset; call reset first");
  require_length("actions", actions.size(), given_.size());
  // A copy: other threads may write to the caller's.
  std::ranges::copy(actions, given_.begin());
  batch_.check_actions(given_);
  scale();
  batch_.step(scaled_);
  past_.swap(smoothed_);
  BatchAccess::for_ranges(batch_, [this](int part, int /*worker*/, Range envs) {
    finish(BatchAccess::data(batch_.part(part)), envs);
  });
  for (int i = 0; i < batch_.num_parts(); ++i) {
    const BatchData& data = BatchAccess::data(batch_.part(i));
    if (data.batch_task != nullptr) finish(data, {0, data.num_envs()});
  }
}

void Preset::finish(const BatchData& part, Range envs) {
  for (int env = envs.begin; env < envs.end; ++env) finish(part.first_env + env);
}

void Preset::scale() {
  const auto past = static_cast<float>(options_.smoothing);
  const auto present = static_cast<float>(1 - options_.smoothing);
  const ActionSpace& inner = batch_.action_space();
  const std::size_t dim = scales_.size();
  for (std::size_t i = 0; i < given_.size(); ++i) {
    const std::size_t k = i % dim;
    const float action = past > 0 ? present * given_[i] + past * past_[i] : given_[i];
    smoothed_[i] = action;
    scaled_[i] = options_.scale_actions
                     ? std::clamp(action * scales_[k], inner.low[k], inner.high[k])
                     : action;
  }
}

// Reward, ends and observations of an environment, after a step.
void Preset::finish(int env) {
  const bool ended = (terminated_[env] | truncated_[env]) != 0;
  const bool same_step = auto_reset_ == AutoReset::kSameStep;
  const bool was_over = over_[at(env)] != 0;
  const Source& source = same_step && ended ? last_ : now_;
  reward_[at(env)] =
      shaping_.step(env, {.reward = source.reward[env],
                          .reward_terms = source.reward_terms.row(env),
                          .elapsed = source.elapsed[env],
                          .failed = terminated_[env] != 0 && source.success[env] == 0,
                          .success_once = source.success_once[env] != 0,
                          .idle = was_over});
  if (same_step && ended) write_row(last_, env, false, final_observation_.data());
  const bool begins = same_step ? ended : was_over && auto_reset_ == AutoReset::kNextStep;
  if (begins) begin(env);
  write_row(now_, env, begins, observation_.data());
  if (same_step) return;
  over_[at(env)] = ended || (was_over && auto_reset_ == AutoReset::kOff) ? 1 : 0;
}

void Preset::begin(int env) {
  shaping_.begin(env);
  const std::size_t dim = scales_.size();
  std::fill_n(past_.begin() + static_cast<std::ptrdiff_t>(at(env) * dim), dim, 0.0F);
}

void Preset::write_row(const Source& source, int env, bool begins, float* rows) {
  if (dim_ == 0) return;
  const float* const row = source.rows.row(env);
  float* const out = rows + at(env) * at(dim_);
  if (states_) {
    states_->write(row, out);
  } else if (!objects_) {
    std::copy_n(row, source.rows.width(), out);
  } else if (&source == &last_) {
    objects_->write_last(env, row, out);
  } else {
    objects_->write(env, row, begins, out);
  }
  if (!options_.time_left) return;
  const double horizon = horizons_[at(env)];
  out[dim_ - 1] = static_cast<float>((horizon - source.elapsed[env]) / horizon);
}

}  // namespace engram::training
