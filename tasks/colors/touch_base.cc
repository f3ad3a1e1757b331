#include "tasks/colors/touch_base.h"

#include <algorithm>

#include "core/base/index.h"
#include "core/image/overlay.h"
#include "tasks/common/colors.h"

namespace engram::tasks {
namespace {

constexpr double kTouchGap = 0.005;  // m: touch points are that far above a cube

}  // namespace

ColorTouchBase::ColorTouchBase(const RegistryEntry& entry, const ColorRecallParams& params)
    : FamilyBase(entry),
      params_(params),
      variables_(RandomVariables(info_.random_variables), params),
      options_(TaskOptions(info_.options), params),
      rule_(params.rule),
      cubes_(scene_, params, variables_.positions),
      touch_({params.COLORS, params.CUBE_HALFSIZE + kTouchGap, params.SEQUENCE_LENGTH,
              options_.repeated_touches.has_value()}) {
  describe_color_recall(params, info_);
  declare_sampled_values(*this);
}

void ColorTouchBase::bind_touches(const Bindings& bindings) {
  FamilyBase::bind(bindings);
  clock_.bind(*bindings.memory);
  touch_.bind(bindings, options_.touch_radius.value(bindings));
  const auto& strict_order = options_.strict_order;
  if (strict_order && strict_order->is_on(bindings)) rule_ = ColorRule::kSeqStrict;
  refuses_repeats_ = options_.repeated_touches && !options_.repeated_touches->is_on(bindings);
}

void ColorTouchBase::bind_sequence(const Bindings& bindings) {
  ColumnStore& memory = *bindings.memory;
  reward_dict_.bind(bindings, info_.reward_terms.size());
  sequence_ = memory.add<std::int32_t>("sequence", params_.SEQUENCE_LENGTH);
  memory.limit("sequence", 0, params_.COLORS - 1);
  cubes_.bind(bindings);
  goal_ = memory.add<double>("obj_to_goal_pos", 3, "m");
}

void ColorTouchBase::bind_info(ColumnStore& info) {
  obj_to_goal_pos_ =
      info.add_privileged<float>("obj_to_goal_pos", 3, "m", "next goal minus TCP position");
  is_robot_static_ = info.add<std::uint8_t>("is_robot_static");
}

// --- sampling ---

void ColorTouchBase::begin_episode(const Episode& episode) const {
  const int env = episode.env();
  draw_sequence(episode);
  cubes_.reset(episode);
  clock_.reset(env, params_.cue_items() * variables_.cue_steps.sample(episode),
               variables_.empty_steps.sample(episode));
  touch_.reset(env);
}

void ColorTouchBase::draw_sequence(const Episode& episode) const {
  std::int32_t* sequence = sequence_.row(episode.env());
  if (const double* pinned = variables_.sequence.pinned(episode)) {
    std::transform(pinned, pinned + params_.SEQUENCE_LENGTH, sequence,
                   [](double value) { return static_cast<std::int32_t>(value); });
    return;
  }
  ColorPermutation storage{};
  const std::span colors =
      shuffled_colors(params_.COLORS, storage, variables_.sequence.stream(episode));
  std::copy_n(colors.begin(), params_.SEQUENCE_LENGTH, sequence);
}

// --- phases ---

void ColorTouchBase::show_phase(int env, int kept_steps) const {
  const int elapsed = engine_.state->elapsed[env];
  switch (clock_.phase(env, elapsed)) {
    case Phase::kCue:
      cubes_.show_cue(env, sequence(env), elapsed, clock_.cue_end(env));
      break;
    case Phase::kEmpty:
      if (clock_.begins(env, elapsed)) cubes_.hide_all(env, sequence(env));
      break;
    case Phase::kManipulation:
      if (elapsed < clock_.manipulation_start(env) + kept_steps) cubes_.show_all(env);
      break;
  }
}

// --- touches ---

TouchTally ColorTouchBase::count_touches(int env) const {
  TouchTally tally = tally_touches(rule_, sequence(env), {touch_.touched(env), at(params_.COLORS)},
                                   touch_.order(env));
  if (refuses_repeats_ && touch_.repeated(env)) {
    tally.order_ok = false;
    tally.mistaken = true;
  }
  return tally;
}

TouchTally ColorTouchBase::evaluate_touches(int env) const {
  touch_.evaluate(env, is_acting(env));
  const TouchTally tally = count_touches(env);
  if (tally.mistaken || tally.complete()) {
    const int number = answer_number(touch_.order(env), params_.SEQUENCE_LENGTH);
    engine_.answers.give(env, number, tally.complete());
  }
  std::copy_n(sequence_.row(env), params_.SEQUENCE_LENGTH, engine_.oracle_info.row(env));
  return tally;
}

bool ColorTouchBase::note_static(int env) const {
  const bool still = robot_is_static(*engine_.state, env);
  is_robot_static_[env] = still ? 1 : 0;
  return still;
}

void ColorTouchBase::set_goal(int env, const Eigen::Vector3d& goal) const {
  Eigen::Map<Eigen::Vector3d>(goal_.row(env)) = goal;
  for (int i = 0; i < 3; ++i) obj_to_goal_pos_.row(env)[i] = static_cast<float>(goal[i]);
}

bool ColorTouchBase::in_sequence(int env, int color) const {
  const std::span<const std::int32_t> colors = sequence(env);
  return std::find(colors.begin(), colors.end(), color) != colors.end();
}

ColorTouchReward ColorTouchBase::touch_reward(int env) const {
  return {.goal_distance = Eigen::Map<const Eigen::Vector3d>(goal_.row(env)).norm(),
          .arm_speed = Eigen::Map<const ArmVector>(engine_.state->qvel.row(env)).norm(),
          .tally = count_touches(env),
          .length = params_.SEQUENCE_LENGTH,
          .acting = is_acting(env),
          .success = engine_.success[env] != 0,
          .robot_static = is_robot_static_[env] != 0,
          .rule = params_.rule};
}

// --- overlay ---

void ColorTouchBase::overlay(int env, Overlay& out) const {
  constexpr double kLeft = 130;  // right of "Target:"
  constexpr double kPitch = 25;
  out.add(OverlayText{{10, 60}, "Target:"});
  double x = kLeft;
  for (const std::int32_t color : sequence(env)) {
    const auto& rgba = COLOR_MAPPING[at(color)].rgba;
    const auto byte = [&rgba](std::size_t i) { return static_cast<std::uint8_t>(rgba[i]); };
    const std::uint8_t border = touch_.touched(env)[color] != 0 ? 255 : 0;
    out.add(OverlaySwatch{{x, 45}, 15, {byte(0), byte(1), byte(2)}, {border, border, border}});
    x += kPitch;
  }
}

}  // namespace engram::tasks
