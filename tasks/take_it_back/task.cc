#include "tasks/take_it_back/task.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

#include "core/math/real_functions.h"
#include "mjcf/scene.h"
#include "mjcf/target_disc.h"
#include "tasks/common/family_base.h"
#include "tasks/common/phase_budget.h"
#include "tasks/common/random_variables.h"
#include "tasks/common/reward_dict.h"
#include "tasks/common/task_info.h"
#include "tasks/common/task_options.h"
#include "tasks/common/variant.h"
#include "tasks/take_it_back/annotator.h"
#include "tasks/take_it_back/expert.h"
#include "tasks/take_it_back/layout.h"

namespace engram::tasks {
namespace {

using Vec2 = Eigen::Vector2d;
using Vector = Eigen::Vector3d;

// --- parameters ---

struct Params {
  TaskSpec task;
  double GOAL_RADIUS = 0.08;    // m
  double CUBE_HALFSIZE = 0.02;  // m
  // None: rewards know no action cost.
  std::optional<SmoothnessParams> smoothness =
      SmoothnessParams{.ACTION_L2_COEF = 0.01, .ACTION_DELTA_L2_COEF = 0.08, .QVEL_L2_COEF = 0.01};
  TakeItBackShaping shaping = {};

  void declare(ConstantBinder& constants);
  void check(int horizon) const;
};

constexpr std::array<Params, 2> kVariants = {{
    {{"TakeItBack-VLA-v0", 60, Split::kShort}},
    {.task = {"TakeItBack-v0", 180, Split::kRl},
     .smoothness = std::nullopt,
     .shaping = {.in_place = 0.01, .in_goal_weight = 0, .contact_weight = 0}},
}};

constexpr int kTimeToAct = 45;  // control steps, there and back
constexpr double kSuccessReward = 30;
constexpr double kRegionHeight = 0.001;  // m
constexpr double kHiddenHeight = 1000;   // reported while a region is hidden

constexpr double kStartX = 0.05;  // m, to either side
// Distance of the cube from a place into which it has come, m: discs that the path to another one
// of them does not cross.
constexpr double kAtPlace = 0.04;

constexpr mjcf::Rgba kLime = {0, 1, 0, 1};
constexpr mjcf::Rgba kBlue = {0, 0, 1, 1};
constexpr mjcf::Rgba kRed = {194 / 255.0, 19 / 255.0, 22 / 255.0, 1};
constexpr mjcf::Rgba kViolet = {147 / 255.0, 0, 211 / 255.0, 1};

// Random variables of an episode.
struct Variables {
  explicit Variables(RandomVariables list)
      : slot(list.integer("slot", {-1, 1}, "", "where the cube starts: right, middle or left")),
        initial_x(list.real("initial_x", {-kStartX, kStartX}, "m", "where the cube starts")),
        initial_shift(list.real("initial_shift", {0, kSlotWidth}, "m",
                                "where the cube starts, in y in its slot")),
        goal_x(list.real("goal_x", {0.2, 0.25}, "m", "where the target lies")),
        goal_y(list.real("goal_y", {-0.025, 0.025}, "m", "where the target lies")) {}

  IntegerVariable slot;
  RealVariable initial_x;
  RealVariable initial_shift;
  RealVariable goal_x;
  RealVariable goal_y;
};

// Values of a variable that is drawn again and again.
class RepeatedDraws {
 public:
  RepeatedDraws(const Episode& episode, const RealVariable& variable)
      : pinned_(variable.pinned(episode)), stream_(variable.stream(episode)), variable_(variable) {}

  double next() {
    return pinned_ != nullptr ? *pinned_ : stream_.uniform(variable_.low(), variable_.high());
  }

 private:
  const double* pinned_;
  RandomStream stream_;
  const RealVariable& variable_;
};

void Params::declare(ConstantBinder& constants) {
  constants.real(
      "GOAL_RADIUS", GOAL_RADIUS, {0.02, 0.1}, "m",
      "how near the centre of target and start the cube has to be; twice that lies between them");
  constants.real("CUBE_HALFSIZE", CUBE_HALFSIZE, {0.01, 0.03}, "m",
                 "half the side of the cube; its mass grows with it");
  if (smoothness) smoothness->declare(constants);
}

void Params::check(int horizon) const { check_horizon(horizon, {}, kTimeToAct); }

// Success rate of an agent that has not seen the start: how often it brings the cube near it, on
// the path from the target to the middle of a slot, or there.
double guess_rate(double radius) {
  constexpr int kGrid = 40;  // points in x and in y
  const Vec2 target(0.225, 0);
  int right = 0;
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const double x = kStartX * (2 * (i % kGrid + 0.5) / kGrid - 1);
    const double shift = kSlotWidth * (i / kGrid + 0.5) / kGrid;
    for (int slot = -1; slot <= 1; ++slot) {
      for (int guess = -1; guess <= 1; ++guess) {
        const Vec2 path = middle_of_slot(guess) - target;
        const Vec2 start = Vec2(x, kSlotPitch * slot + shift) - target;
        const double part = std::clamp(start.dot(path) / path.squaredNorm(), 0.0, 1.0);
        right += (start - part * path).norm() < radius ? 1 : 0;
      }
    }
  }
  return right / static_cast<double>(kGrid * kGrid * kSlots * kSlots);
}

// What rewards of all steps depend on.
TakeItBackReward form_of(const Params& params) {
  return {.cube_halfsize = params.CUBE_HALFSIZE,
          .smoothness = params.smoothness.value_or(SmoothnessParams{}),
          .shaping = params.shaping,
          .lists_smoothness = params.smoothness.has_value()};
}

class TakeItBack final : public FamilyBase {
 public:
  TakeItBack(const RegistryEntry& entry, const Params& params)
      : FamilyBase(entry),
        params_(params),
        variables_(RandomVariables(info_.random_variables)),
        may_overlap_(TaskOptions(info_.options)
                         .on_off("may_overlap",
                                 "1: the discs of start and target may overlap, which makes "
                                 "success easy",
                                 /*original=*/true)),
        expert_({.engine = engine_,
                 .initial = initial_,
                 .slot = slot_,
                 .goal = goal_,
                 .reached = reached_,
                 .goal_radius = params.GOAL_RADIUS,
                 .cube_halfsize = params.CUBE_HALFSIZE}),
        annotator_({.engine = engine_, .initial = initial_, .reached = reached_}) {
    info_.candidates = kSlots;
    info_.guess_rate = guess_rate(params.GOAL_RADIUS);
    info_.answer =
        "where the cube comes, or rests, first after the target: its first place, or the same in "
        "another slot; the slot, -1, 0 or 1";
    if (entry.is_rl()) info_.answer += kSuccessAnswers;
    info_.answer_rate = 1.0 / kSlots;
    info_.success_reward = kSuccessReward;
    info_.oracle_dim = 3;
    info_.oracle_is_real = true;
    info_.reward_terms = reward_terms_of(form_of(params));
    info_.phases = {{"there", "the cube has not been on the target"},
                    {"back", "the cube has been on the target"}};
    declare_state(*this);
    // People see where the cube started; the robot's cameras do not.
    const double radius = params.GOAL_RADIUS;
    scene_.props.resize(kProps);
    scene_.props[kCube] = mjcf::cube("cube", params.CUBE_HALFSIZE, kLime);
    scene_.props[kInitialRegion] =
        mjcf::target_disc("initial_region", radius, kBlue, /*hidden_from_sensors=*/true);
    scene_.props[kGoalRegion] = mjcf::target_disc("goal_region", radius, kRed);
    scene_.props[kChangedGoalRegion] = mjcf::target_disc("changed_goal_region", radius, kViolet);
  }

  void bind(const Bindings& bindings) override {
    FamilyBase::bind(bindings);
    goal_achieved_ =
        bindings.outputs->add<std::uint8_t>("goal_achieved", 1, "", "the cube is on the target");
    goal_reached_status_ = bindings.outputs->add<std::uint8_t>("goal_reached_status", 1, "",
                                                               "it has been on the target");
    reward_dict_.bind(bindings, info_.reward_terms.size());
    reached_ = bindings.memory->add<std::uint8_t>("reached");
    slot_ = bindings.memory->add<std::int32_t>("slot");
    bindings.memory->limit("slot", -1, 1);
    initial_ = bindings.memory->add<double>("initial", 2, "m");
    goal_ = bindings.memory->add<double>("goal", 2, "m");
  }

  // The cube shows where it started until it is moved, which is up to the agent.
  int cue_end(int /*env*/) const override { return 0; }

  // --- sampling ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    draw_positions(episode);
    place_upright(*engine_.state, env, kCube, initial(env), params_.CUBE_HALFSIZE);
    show_region(env, kInitialRegion, initial(env));
    show_region(env, kGoalRegion, goal(env));
    hide_region(env, kChangedGoalRegion, goal(env));
  }

  // --- phases ---

  // The target changes colour one step after the cube has reached it, for good.
  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      if (reached_[env] == 0) continue;
      hide_region(env, kGoalRegion, goal(env));
      show_region(env, kChangedGoalRegion, goal(env));
    }
  }

  // --- success ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const bool achieved = (cube(env).head<2>() - goal(env)).norm() < params_.GOAL_RADIUS;
      const bool returned = (cube(env).head<2>() - initial(env)).norm() < params_.GOAL_RADIUS;
      if (achieved) reached_[env] = 1;
      goal_achieved_[env] = achieved ? 1 : 0;
      goal_reached_status_[env] = reached_[env];
      note_answer(env);
      const bool counts = reached_[env] != 0 && (!engine_.strict || engine_.answers.given(env));
      const bool success = returned && counts;
      engine_.success[env] = success ? 1 : 0;
      // The rule of such a task ends the episode before the cube is brought nearer.
      if (success && info_.termination == Termination::kSuccess && !engine_.answers.given(env)) {
        engine_.answers.give(env, slot_[env], true);
      }
      RowWriter(engine_.oracle_values.row(env)).add(region_position(initial(env)));
      reward_dict_.publish(env);
    }
  }

  // --- reward ---

  void dense_reward(Range envs, FloatRows out) override {
    reward_dict_.write(envs, out, [&](int env) {
      TakeItBackReward reward = form_of(params_);
      reward.cube = cube(env);
      reward.tcp = tcp_pos(env);
      reward.goal = goal(env);
      reward.initial = initial(env);
      reward.action_cost = measure_action_cost(engine_, env);
      reward.on_target = goal_achieved_[env] != 0;
      reward.reached = reached_[env] != 0;
      reward.success = engine_.success[env] != 0;
      return reward;
    });
  }

  // --- observation ---

  template <class Visitor>
  void state_row(Visitor& row, int env) const {
    row.field("goal_pos", 3, "m", "centre of the target",
              [&] { return region_position(goal(env)); });
    row.field("cube_pose", 7, "m", "position, quaternion (w, x, y, z)",
              [&] { return prop_pose(env, kCube); });
    row.field("oracle_info", 3, "m", "where the cube started",
              [&] { return region_position(initial(env)); });
    row.field("goal_reached_status", 1, "", "it has been on the target",
              [&] { return reached_[env]; });
  }
  void observe(Range envs, FloatRows out) override { write_state(*this, envs, out); }

  // --- expert ---

  const Expert& expert() const override { return expert_; }
  const Annotator* annotator() const override { return &annotator_; }

 private:
  Vector cube(int env) const { return prop_pos(env, kCube); }
  Vec2 initial(int env) const { return Eigen::Map<const Vec2>(initial_.row(env)); }
  Vec2 goal(int env) const { return Eigen::Map<const Vec2>(goal_.row(env)); }
  static Vector region_position(const Vec2& center) {
    return {center.x(), center.y(), kRegionHeight};
  }

  // After the target the cube has come near a place, or stays a little farther off.
  void note_answer(int env) const {
    if (reached_[env] == 0 || goal_achieved_[env] != 0 || engine_.answers.given(env)) return;
    int nearest = 0;
    double least = std::numeric_limits<double>::max();
    for (int slot = -1; slot <= 1; ++slot) {
      const Vec2 place = initial(env) + Vec2(0, kSlotPitch * (slot - slot_[env]));
      const double away = (cube(env).head<2>() - place).norm();
      if (away >= least) continue;
      least = away;
      nearest = slot;
    }
    const bool stays = least < params_.GOAL_RADIUS && prop_is_static(*engine_.state, env, kCube);
    if (least < kAtPlace || stays) engine_.answers.give(env, nearest, nearest == slot_[env]);
  }

  void show_region(int env, int prop, const Vec2& center) const {
    place_upright(*engine_.state, env, prop, center, kRegionHeight);
  }
  void hide_region(int env, int prop, const Vec2& center) const {
    const double pos[3] = {center.x(), center.y(), kHiddenHeight};
    engine_.state->hide_prop(env, prop, pos);
  }

  // Start and target; drawn again, the slot aside, while their discs overlap and may not.
  void draw_positions(const Episode& episode) const {
    // Pins may leave no choice.
    const int max_draws = may_overlap_.is_on(engine_) ? 1 : 100;
    const int slot = variables_.slot.sample(episode);
    slot_[episode.env()] = slot;
    RepeatedDraws initial_x(episode, variables_.initial_x);
    RepeatedDraws initial_shift(episode, variables_.initial_shift);
    RepeatedDraws goal_x(episode, variables_.goal_x);
    RepeatedDraws goal_y(episode, variables_.goal_y);
    double* start = initial_.row(episode.env());
    double* target = goal_.row(episode.env());
    for (int attempt = 0; attempt < max_draws; ++attempt) {
      start[0] = initial_x.next();
      start[1] = kSlotPitch * slot + initial_shift.next();
      target[0] = goal_x.next();
      target[1] = goal_y.next();
      if (real::hypot(target[0] - start[0], target[1] - start[1]) >= 2 * params_.GOAL_RADIUS)
        return;
    }
  }

  Params params_;
  Variables variables_;
  TaskOption may_overlap_;
  RewardDict reward_dict_;
  Column<std::uint8_t> goal_achieved_;
  Column<std::uint8_t> goal_reached_status_;
  Column<std::int32_t> slot_;
  Column<std::uint8_t> reached_;  // latched: the stage switch
  Column<double> initial_;        // (2) m
  Column<double> goal_;           // (2) m
  TakeItBackExpert expert_;
  TakeItBackAnnotator annotator_;
};

}  // namespace

double TakeItBackReward::compute() {
  constexpr double kPushGap = 0.005;  // m from the cube's face
  constexpr double kPullGap = 0.01;   // m
  smooth = tasks::smoothness(action_cost, smoothness);
  push_distance = (cube + Vector(-cube_halfsize - kPushGap, 0, 0) - tcp).norm();
  pull_distance = (cube + Vector(cube_halfsize + kPullGap, 0, 0) - tcp).norm();
  at_push_point = push_distance < shaping.in_place;
  at_pull_point = pull_distance < shaping.in_place;
  reaching_push = 1 - real::tanh(5 * push_distance);
  reaching_pull = 1 - real::tanh(5 * pull_distance);
  contact = 1 - real::tanh(6 * (cube - tcp).norm());
  in_goal = 1 - real::tanh(5 * (cube.head<2>() - goal).norm());
  back = 1 - real::tanh(5 * (cube.head<2>() - initial).norm());
  if (success) return kSuccessReward;
  if (reached) {
    const double reward = 10 * reaching_pull + shaping.contact_weight * contact - smooth.penalty;
    return at_pull_point ? reward + 15 * back : reward;
  }
  const double reward = 2 * reaching_push + shaping.in_goal_weight * in_goal - smooth.penalty;
  return at_push_point ? reward + 5 * in_goal : reward;
}

constexpr auto kRows = rows_of(kVariants);

const Family kTakeItBack = {
    .name = "TakeItBack",
    .memory_type = "Spatial",
    .instruction =
        "Push the cube onto the red target, and when the target changes color, return the cube "
        "to its original position.",
    .tasks = kRows,
    .make = make_variant<TakeItBack, kVariants>,
    .expectations = {.min_reward = -0.0034, .max_reward = 0.7531, .hides = true},
    .memory = {.hidden = "slot", .cue_by_hand = true}};

}  // namespace engram::tasks
