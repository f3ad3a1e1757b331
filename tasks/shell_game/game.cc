#include "tasks/shell_game/game.h"

#include <algorithm>
#include <array>

#include "core/base/index.h"
#include "core/image/overlay.h"
#include "tasks/common/poses.h"

namespace engram::tasks {
namespace {

constexpr double kBallReleaseGap = 0.05;  // m: a mug lifted further leaves its ball behind

}  // namespace

ShellGame::Variables::Variables(RandomVariables list, const ShellGameParams& params,
                                const Setup& setup)
    : target(list.integer(setup.target, {0, kCups - 1}, "", setup.target_description)),
      base(Mugs::declare_base(list)),
      cue_steps(list.of(params.CUE_PHASE_STEPS)) {}

ShellGame::ShellGame(const RegistryEntry& entry, const ShellGameParams& params, const Setup& setup)
    : FamilyBase(entry),
      mugs_(scene_, params, setup.orientations),
      params_(params),
      setup_(setup),
      variables_(RandomVariables(info_.random_variables), params, setup) {
  info_.candidates = kCups;
  info_.frozen_cue = setup.frozen && !params.task.is_rl();
  info_.success_reward = setup.success_reward;
  info_.oracle_dim = 1;
  declare_sampled_values(*this);
  info_.hidden_variable = setup.target;
  scene_.render_view = mjcf::RenderView::kTable;
}

void ShellGame::bind(const Bindings& bindings) {
  FamilyBase::bind(bindings);
  ColumnStore& memory = *bindings.memory;
  target_ = memory.add<std::int32_t>(setup_.target);
  memory.limit(setup_.target, 0, kCups - 1);
  mugs_.bind(bindings);
  cue_steps_ = memory.add<std::int32_t>("cue_steps", 1, "control steps");
  manipulation_start_ = memory.add<std::int32_t>("manipulation_start", 1, "control steps");
  offset_ = memory.add<double>("obj_to_goal_pos", 3, "m");

  ColumnStore& info = *bindings.outputs;
  info.limit("oracle_info", 0, kCups - 1);
  obj_to_goal_pos_ = info.add_privileged<float>("obj_to_goal_pos", 3, "m");
  is_obj_placed_ = info.add_privileged<std::uint8_t>("is_obj_placed");
  is_robot_static_ = info.add<std::uint8_t>("is_robot_static");
  reward_dict_.bind(bindings, info_.reward_terms.size());
}

// --- sampling ---

void ShellGame::reset(const Episode& episode) {
  const int env = episode.env();
  target_[env] = variables_.target.sample(episode);
  mugs_.reset(episode, variables_.base);
  cue_steps_[env] = variables_.cue_steps.sample(episode);
  start_manipulation_at(env, cue_steps_[env]);
}

// --- phases ---

void ShellGame::start_manipulation_at(int env, int elapsed) const {
  manipulation_start_[env] = elapsed;
  if (info_.frozen_cue) engine_.freeze_steps[env] = elapsed;
}

std::vector<std::pair<std::string, std::string>> cue_manipulation_phases() {
  return {{"cue", "elapsed < cue_steps"}, {"manipulation", "elapsed >= cue_steps"}};
}

int ShellGame::add_red_ball() {
  scene_.props.push_back(mjcf::visual_sphere("red_ball", params_.BALL_RADIUS, {1, 0, 0, 1}));
  return static_cast<int>(scene_.props.size()) - 1;
}

int ShellGame::add_goal_site(double radius) {
  scene_.props.push_back(mjcf::visual_sphere("goal_site", radius, {0, 1, 0, 1}));
  scene_.props.back().geoms[0].hidden_from_sensors = true;
  return static_cast<int>(scene_.props.size()) - 1;
}

void ShellGame::place_sphere(int env, int sphere, const Eigen::Vector3d& pos) const {
  engine_.state->place_prop(env, sphere, pos.data(), kUprightQuat);
}

void ShellGame::update_free_mugs(int env, int ball, bool lifted_along) const {
  const int cup = target_[env];
  if (engine_.state->elapsed[env] == 0) {
    place_sphere(env, ball, mugs_.slot_pos(env, cup, params_.BALL_RADIUS));
  }
  if (manipulation_begins(env)) mugs_.stand_all(env);
  if (lifted_along && is_manipulation(env)) return carry_ball(env, ball, cup);
  const Eigen::Vector3d over = mugs_.pos(env, cup);
  if (is_manipulation(env) && over.z() <= mugs_.resting_height() + kBallReleaseGap) {
    place_sphere(env, ball, {over.x(), over.y(), params_.BALL_RADIUS});
  }
  cover_ball(env, ball, cup);
}

void ShellGame::cover_ball(int env, int ball, int mug) const {
  const bool covered = is_manipulation(env) && mugs_.hides(env, mug);
  engine_.state->covered[env] = std::uint64_t{covered} << ball;
}

void ShellGame::carry_ball(int env, int ball, int mug) const {
  Eigen::Vector3d pos = mugs_.pos_inside(env, mug, params_.BALL_RADIUS);
  pos.z() = std::max(pos.z(), params_.BALL_RADIUS);
  place_sphere(env, ball, pos);
  engine_.state->covered[env] = std::uint64_t{mugs_.encloses(env, mug)} << ball;
}

// --- success and info ---

void ShellGame::set_outcome(int env, const Outcome& outcome) const {
  for (int i = 0; i < 3; ++i) {
    offset_.row(env)[i] = outcome.obj_to_goal[i];
    obj_to_goal_pos_.row(env)[i] = static_cast<float>(outcome.obj_to_goal[i]);
  }
  is_obj_placed_[env] = outcome.placed ? 1 : 0;
  is_robot_static_[env] = outcome.still ? 1 : 0;
  const bool counts =
      engine_.state->elapsed[env] >= manipulation_start_[env] + params_.first_success;
  const bool success = outcome.placed && outcome.still && outcome.extra_condition && counts;
  engine_.success[env] = success ? 1 : 0;
  reward_dict_.publish(env);
}

int ShellGame::moved_mug(int env, double least) const {
  if (!is_manipulation(env)) return -1;
  int moved = -1;
  for (int mug = 0; mug < kCups; ++mug) {
    const double distance = (mugs_.pos(env, mug) - mugs_.standing_pos(env, mug)).norm();
    if (distance <= least) continue;
    least = distance;
    moved = mug;
  }
  return moved;
}

void ShellGame::reveal_answer() {
  answer_visible_ = true;
  info_.guess_rate = 1;
  info_.answer_rate = 1;
}

// --- overlay ---

void ShellGame::overlay(int env, Overlay& out) const {
  static constexpr std::array<const char*, kCups> kTitles = {"Left", "Center", "Right"};
  const auto slot = at(answer(env));
  out.add(OverlayText{{10, 60}, std::string("Target: ") + kTitles[slot]});
}

}  // namespace engram::tasks
