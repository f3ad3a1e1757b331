// The preset for training, in C.
#include <string>

#include "api/c_batch.h"
#include "api/c_convert.h"
#include "api/c_options.h"
#include "engram/engram_training_c.h"
#include "protocol/training/preset.h"

using engram::c::convert;
using engram::c::refuse_null;
using engram::c::with_env;

// NOLINTNEXTLINE(readability-identifier-naming): the name is of the C API
struct engram_training {
  engram_env* env;
  engram::training::Preset preset;
};

namespace {

engram::training::Options to_options(const engram_training_options& options) {
  if (options.struct_size != sizeof options) {
    engram::c::refuse(
        "options.struct_size", std::to_string(options.struct_size),
        std::to_string(sizeof options) + " needed; call engram_training_options_init first");
  }
  engram::training::Options out;
  // begin generated: conversions (tools/surface, from api/surface.toml)
  convert("gamma", options.gamma, out.gamma);
  convert("scale_actions", options.scale_actions, out.scale_actions);
  convert("smoothing", options.smoothing, out.smoothing);
  convert("scale_observations", options.scale_observations, out.scale_observations);
  convert("time_left", options.time_left, out.time_left);
  convert("potential", options.potential, out.potential);
  convert("still", options.still, out.still);
  convert("bonus", options.bonus, out.bonus);
  // end generated
  return out;
}

// A constant of the preset, or the address of an array.
template <class T, class F>
T preset_constant(const engram_training* training, T otherwise, F&& f) noexcept {
  if (training != nullptr) return f(training->preset);
  refuse_null("training");
  return otherwise;
}

template <class F>
const float* preset_array(const engram_training* training, F&& f) noexcept {
  const float* const none = nullptr;
  return preset_constant(training, none, [&f](const engram::training::Preset& of) -> const float* {
    const auto& values = f(of);
    return values.empty() ? nullptr : values.data();
  });
}

}  // namespace

void engram_training_options_init(engram_training_options* options) {
  if (options == nullptr) {
    refuse_null("options");
    return;
  }
  *options = {};
  options->struct_size = sizeof *options;
  // begin generated: defaults
  options->gamma = 0.99;
  options->scale_actions = 1;
  options->smoothing = 0.0;
  options->scale_observations = 1;
  options->time_left = 1;
  options->potential = 1.0;
  options->still = 0.0;
  options->bonus = 0.1;
  // end generated
}

engram_status engram_training_make(engram_env* env, const engram_training_options* options,
                                   engram_training** training) {
  if (training == nullptr) return refuse_null("training");
  *training = nullptr;
  return with_env(env, [&](engram_env& of) {
    engram::training::Options given;
    if (options != nullptr) given = to_options(*options);
    *training = new engram_training{env, engram::training::Preset(*of.batch, given)};
  });
}

void engram_training_close(engram_training* training) { delete training; }

engram_status engram_training_reset(engram_training* training,
                                    const engram_reset_request* request) {
  if (training == nullptr) return refuse_null("training");
  return with_env(training->env, [&](engram_env& of) {
    const engram::c::GivenReset given(request, of.batch->num_envs());
    training->preset.reset(given.request());
  });
}

engram_status engram_training_step(engram_training* training, const float* actions, size_t count) {
  if (training == nullptr) return refuse_null("training");
  if (actions == nullptr) return refuse_null("actions");
  return with_env(training->env, [&](engram_env&) { training->preset.step({actions, count}); });
}

const float* engram_training_action_low(const engram_training* training) {
  return preset_array(
      training, [](const auto& of) -> const auto& { return of.action_space().low; });
}

const float* engram_training_action_high(const engram_training* training) {
  return preset_array(
      training, [](const auto& of) -> const auto& { return of.action_space().high; });
}

int32_t engram_training_observation_dim(const engram_training* training) {
  return preset_constant(training, 0, [](const auto& of) { return of.observation_dim(); });
}

const float* engram_training_observation(const engram_training* training) {
  return preset_array(training, [](const auto& of) { return of.observation(); });
}

const float* engram_training_final_observation(const engram_training* training) {
  return preset_array(training, [](const auto& of) { return of.final_observation(); });
}

const float* engram_training_reward(const engram_training* training) {
  return preset_array(training, [](const auto& of) { return of.reward(); });
}
