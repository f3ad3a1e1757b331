#include "tasks/remember/object_recall.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/index.h"
#include "core/base/join.h"
#include "tasks/common/overlap_guard.h"
#include "tasks/common/phase_budget.h"
#include "tasks/common/task_info.h"
#include "tasks/common/touch_latch.h"

namespace engram::tasks {
namespace {

constexpr SpreadParams kSpread;

constexpr int kTimeToAct = 15;     // control steps that a touch takes
const Vec2 kRobotBase(-0.615, 0);  // m
constexpr double kReach = 0.86;    // m

Layout sample_layout(const ObjectRecallParams& params, const ObjectSet& objects,
                     const Layout& nominal, bool spread, RandomStream& random) {
  const bool whole = params.objects.vocabulary == Vocabulary::kShapeAndColor;
  const double size = objects.size();
  const auto draw = [&] {
    const Layout slots =
        whole ? jitter_layout(nominal, size, random) : jitter_slots(nominal, size, random);
    Layout layout = assign_slots(slots, random);
    if (spread) spread_and_stretch(layout, kSpread, size, random);
    return layout;
  };
  return draw_clear_layout(draw, objects.gaps());
}

// Throws Error unless objects can stand apart, and within reach, about their slots.
void check_layouts(const ObjectRecallParams& params) {
  constexpr int kLayouts = 20;
  const ObjectSet objects(params.objects);
  const Layout slots = nominal_slots(objects.count(), params.arc);
  const auto reached = [](const Vec2& point) { return (point - kRobotBase).norm() <= kReach; };
  for (int i = 0; i < kLayouts; ++i) {
    RandomStream random(0, static_cast<std::uint64_t>(i), 0);
    const Layout layout = sample_layout(params, objects, slots, false, random);
    if (std::ranges::all_of(layout, reached) && is_clear(layout, objects.gaps())) continue;
    throw Error(Error::kInvalidArgument, std::to_string(objects.count()) +
                                             " objects of half size " + shortest(objects.size()) +
                                             " m do not stand apart: their places are " +
                                             in_millimetres(min_distance(slots)) +
                                             " from one another, and an object is up to " +
                                             in_millimetres(objects.greatest_width()) + " wide");
  }
}

}  // namespace

void ObjectRecallParams::declare(ConstantBinder& constants) {
  const bool rl = task.is_rl();
  objects.declare(constants, !rl);
  // The original's RL tasks have one length of each phase, by other names.
  constants
      .steps("CUE_PHASE_STEPS", CUE_PHASE_STEPS, kPhaseSteps, "how long the cue is shown",
             {"cue_steps", "length of the cue phase"})
      .published = !rl;
  constants
      .steps("EMPTY_PHASE_STEPS", EMPTY_PHASE_STEPS, kPhaseSteps,
             "how long the table is empty then", {"empty_steps", "length of the empty phase"})
      .published = !rl;
  if (rl) {
    constants.fixed(
        {{"TIME_OFFSET", CUE_PHASE_STEPS.high}, {"delta_time", EMPTY_PHASE_STEPS.high}});
  }
  constants.real("GOAL_THRESH", GOAL_THRESH, {0.005, 0.2}, "m",
                 "how near its object's origin the tool has to come");
  if (!rl) {
    constants.fixed({{"MANIP_WIDTH_AXIS", kSpread.MANIP_WIDTH_AXIS},
                     {"MANIP_WIDTH_SCALE", kSpread.MANIP_WIDTH_SCALE},
                     {"MANIP_WIDTH_CLAMP", kSpread.MANIP_WIDTH_CLAMP}});
  }
  if (smoothness) smoothness->declare(constants);
}

void ObjectRecallParams::check(int horizon) const {
  objects.check();
  check_horizon(
      horizon,
      {{"CUE_PHASE_STEPS", CUE_PHASE_STEPS.high}, {"EMPTY_PHASE_STEPS", EMPTY_PHASE_STEPS.high}},
      kTimeToAct);
  check_layouts(*this);
}

ObjectRecall::ObjectRecall(const RegistryEntry& entry, const ObjectRecallParams& params,
                           const Wording& wording)
    : FamilyBase(entry),
      params_(params),
      variables_(RandomVariables(info_.random_variables), params, wording),
      objects_(params.objects),
      slots_(nominal_slots(params.objects.count, params.arc)),
      touch_(params.GOAL_THRESH, params.smoothness),
      expert_({.engine = engine_,
               .info = info_,
               .objects = objects_,
               .clock = clock_,
               .target = target_,
               .positions = positions_,
               .touch = touch_,
               .goal_thresh = params.GOAL_THRESH}),
      annotator_({.engine = engine_,
                  .objects = objects_,
                  .clock = clock_,
                  .target = target_,
                  .goal_thresh = params.GOAL_THRESH,
                  .imposter = wording.imposter}) {
  info_.candidates = count();
  // The canonical chain freezes the short ids only.
  info_.frozen_cue = entry.split == Split::kShort;
  info_.success_reward = kTouchSuccessReward;
  info_.reward_terms = touch_.reward_terms();
  info_.phases = cue_empty_manipulation_phases();
  info_.answer =
      "the first object within GOAL_THRESH of which the robot rests in the manipulation phase, the "
      "nearest one if there are several; its key";
  info_.hidden_variable = wording.target;
  info_.oracle_dim = static_cast<int>(objects_.identity(0).size());
  declare_state(*this);
  declare_sampled_values(*this);
  for (int key = 0; key < count(); ++key) {
    mjcf::Prop prop = objects_.prop(key);
    const Vec2& slot = slots_[at(key)];
    prop.pos = {slot.x(), slot.y(), objects_.resting_height(key)};
    scene_.props.push_back(std::move(prop));
  }
}

ObjectRecall::Variables::Variables(RandomVariables list, const ObjectRecallParams& params,
                                   const Wording& wording)
    : target(list.integer(wording.target, {0, params.objects.count - 1}, "", wording.target_text)),
      positions(list.add(
          {"positions", 2 * params.objects.count, false, -0.5, 0.5, "m", wording.positions_text})),
      cue_steps(list.of(params.CUE_PHASE_STEPS)),
      empty_steps(list.of(params.EMPTY_PHASE_STEPS)) {}

void ObjectRecall::bind(const Bindings& bindings) {
  FamilyBase::bind(bindings);
  clock_.bind(*bindings.memory);
  touch_.bind(bindings);
  target_ = bindings.memory->add<std::int32_t>("target");
  bindings.memory->limit("target", 0, count() - 1);
  positions_ = bindings.memory->add<double>("positions", 3 * count(), "m");
}

// --- sampling ---

void ObjectRecall::begin_episode(const Episode& episode) const {
  const int env = episode.env();
  target_[env] = variables_.target.sample(episode);
  clock_.reset(env, variables_.cue_steps.sample(episode), variables_.empty_steps.sample(episode));
  if (info_.frozen_cue) engine_.freeze_steps[env] = clock_.manipulation_start(env);
}

Layout ObjectRecall::draw_layout(const Episode& episode, bool spread) const {
  if (const double* pinned = variables_.positions.pinned(episode)) {
    Layout layout;
    for (int key = 0; key < count(); ++key) {
      layout.push_back({pinned[2 * key], pinned[2 * key + 1]});
    }
    return layout;
  }
  RandomStream random = variables_.positions.stream(episode);
  return sample_layout(params_, objects_, slots_, spread, random);
}

void ObjectRecall::set_positions(int env, const Layout& layout) const {
  for (int key = 0; key < count(); ++key) {
    const Vec2& point = layout[at(key)];
    double* pos = position(env, key);
    pos[0] = point.x();
    pos[1] = point.y();
    pos[2] = objects_.resting_height(key);
  }
}

// --- success and reward ---

void ObjectRecall::evaluate(Range envs) {
  for (int env = envs.begin; env < envs.end; ++env) {
    std::ranges::copy(objects_.identity(target_[env]), engine_.oracle_info.row(env));
    touch_.evaluate(env, target_pos(env), success_in_cue_ || is_manipulation(env));
    note_answer(env);
  }
}

// The answer is the object nearest to the tool when that is first within GOAL_THRESH of one, and
// at rest where a touch needs that.
void ObjectRecall::note_answer(int env) const {
  const State& state = *engine_.state;
  if (engine_.answers.given(env) || !is_manipulation(env)) return;
  if (touch_.static_needed() && !robot_is_static(state, env)) return;
  const int key = touched_object(state.prop_pos_of(env, 0), count(), state.tcp_pos.row(env),
                                 params_.GOAL_THRESH);
  if (key >= 0) engine_.answers.give(env, key, key == target_[env]);
}

void ObjectRecall::dense_reward(Range envs, FloatRows out) { touch_.dense_reward(envs, out); }

// --- observation ---

template <class Visitor>
void ObjectRecall::state_row(Visitor& row, int env) const {
  row.field("oracle_info", info_.oracle_dim, "",
            info_.oracle_dim == 1 ? "key of the object to touch" : "ids of its shape and colour",
            [&] { return objects_.identity(target_[env]).data(); });
  static constexpr double kNowhere[3] = {0, 0, 0};
  for (int key = 0; key < count(); ++key) {
    row.field(NumberedName{"goal_", key, "_pose"}, 3, "m",
              "position of this object if it is the one, else zeros",
              [&] { return key == target_[env] ? target_pos(env) : kNowhere; });
  }
}

void ObjectRecall::observe(Range envs, FloatRows out) { write_state(*this, envs, out); }

}  // namespace engram::tasks
