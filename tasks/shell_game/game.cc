#include "tasks/shell_game/game.h"

#include <algorithm>
#include <string>

#include "core/picture/overlay.h"
#include "mjcf/mug.h"
#include "tasks/parts/task_info.h"

namespace engram::tasks {
namespace {

constexpr std::array<const char*, kCups> kMugNames = {"mug_left", "mug_center", "mug_right"};
constexpr double kBaseRange = 0.1;        // m
constexpr double kBallReleaseGap = 0.05;  // m: a mug lifted further leaves its ball behind
constexpr double kUpright[4] = {1, 0, 0, 0};

}  // namespace

// Half turns about horizontal axes at 26.57 and 68.20 degrees.
const MugStance kUpsideDown{mjcf::kMugHandleYaw, {0, 0.894427190999916, 0.447213595499958, 0}};
const MugStance kHandleTowardsRobot{0, {0, 0.371390676354104, 0.928476690885259, 0}};

ShellGame::ShellGame(const RegistryEntry& entry, const Setup& setup)
    : info_(describe(entry)), setup_(setup) {
  info_.candidates = kCups;
  info_.frozen_cue = setup.frozen;
  info_.success_reward = setup.success_reward;
  info_.oracle_dim = 1;
  info_.hidden_draw = setup.target;
  info_.draws = {
      {setup.target, 1, true, 0, kCups - 1, "", setup.target_description},
      {"base", 2, false, -kBaseRange, kBaseRange, "m", "x, y of the center slot"},
      {"cue_steps", 1, true, static_cast<double>(setup.CUE_PHASE_STEPS.low),
       static_cast<double>(setup.CUE_PHASE_STEPS.high), "control steps", "length of the cue phase"},
  };
  info_.constants = {
      {"BALL_RADIUS", BALL_RADIUS},
      {"CUE_PHASE_STEPS", setup.CUE_PHASE_STEPS.constant()},
      {"GOAL_THRESH", setup.GOAL_THRESH},
      {"HEIGHT_OFFSET", HEIGHT_OFFSET},
      {"MIN_DIST", MIN_DIST},
      {"MUG_SCALE", MUG_SCALE},
  };
  for (int slot = 0; slot < kCups; ++slot) {
    mjcf::Prop mug = mjcf::mug(kMugNames[static_cast<std::size_t>(slot)], setup.stance->handle_yaw);
    mug.pos = {0, (slot - 1) * MIN_DIST, mjcf::kMugRestingHeight};
    mug.quat = setup.stance->quat;
    scene_.props.push_back(std::move(mug));
  }
  scene_.render_camera = mjcf::RenderCamera::kB;
}

SceneSource ShellGame::scene() const { return scene_source(scene_); }
std::string ShellGame::document() const { return mjcf::compose(scene_, mjcf::Detail::kFull); }

void ShellGame::bind(const Bindings& bindings) {
  engine_ = bindings;
  ColumnStore& memory = *bindings.memory;
  target_ = memory.add<std::int32_t>(setup_.target);
  memory.limit(setup_.target, 0, kCups - 1);
  base_ = memory.add<double>("base", 2, "m");
  cue_steps_ = memory.add<std::int32_t>("cue_steps", 1, "control steps");
  manipulation_start_ = memory.add<std::int32_t>("manipulation_start", 1, "control steps");
  offset_ = memory.add<double>("obj_to_goal_pos", 3, "m");

  ColumnStore& info = *bindings.outputs;
  info.limit("oracle_info", 0, kCups - 1);
  obj_to_goal_pos_ = info.add<float>("obj_to_goal_pos", 3, "m");
  is_obj_placed_ = info.add<std::uint8_t>("is_obj_placed");
  is_robot_static_ = info.add<std::uint8_t>("is_robot_static");
  reward_dict_.bind(bindings, static_cast<int>(info_.reward_terms.size()));
}

// --- sampling (shell 1.6) ---

void ShellGame::reset(const Episode& episode) {
  const int env = episode.env();
  target_[env] = episode.integer(kTarget, 0, kCups - 1);
  if (const double* pinned = episode.pinned(kBase)) {
    std::copy_n(pinned, 2, base_.row(env));
  } else {
    RandomStream random = episode.stream(kBase);
    for (int i = 0; i < 2; ++i) base_.row(env)[i] = random.uniform(-kBaseRange, kBaseRange);
  }
  const StepRange& cue = setup_.CUE_PHASE_STEPS;
  cue_steps_[env] = episode.integer(kCueSteps, cue.low, cue.high);
  start_manipulation_at(env, cue_steps_[env]);
  for (int mug = 0; mug < kCups; ++mug) hide_mug(env, mug, mug);
}

void ShellGame::start_manipulation_at(int env, int elapsed) const {
  manipulation_start_[env] = elapsed;
  if (info_.frozen_cue) engine_.freeze_steps[env] = elapsed;
}

// --- mugs and ball ---

Eigen::Vector3d ShellGame::mug_slot_pos(int env, int slot) const {
  return slot_pos(env, slot, mjcf::kMugRestingHeight);
}

void ShellGame::hide_mug(int env, int mug, int slot) const {
  const Eigen::Vector3d pos = slot_pos(env, slot, mjcf::kMugRestingHeight + HEIGHT_OFFSET);
  engine_.state->place_prop(env, mug, pos.data(), setup_.stance->quat.data(), PropStatus::kHidden);
}

void ShellGame::stand_mug(int env, int mug, const Eigen::Vector3d& pos) const {
  engine_.state->place_prop(env, mug, pos.data(), setup_.stance->quat.data());
}

int ShellGame::add_red_ball() {
  scene_.props.push_back(mjcf::visual_sphere("red_ball", BALL_RADIUS, {1, 0, 0, 1}));
  return static_cast<int>(scene_.props.size()) - 1;
}

int ShellGame::add_goal_site(double radius) {
  scene_.props.push_back(mjcf::visual_sphere("goal_site", radius, {0, 1, 0, 1}));
  scene_.props.back().primitives[0].hidden_from_sensors = true;
  return static_cast<int>(scene_.props.size()) - 1;
}

void ShellGame::place_sphere(int env, int sphere, const Eigen::Vector3d& pos) const {
  engine_.state->place_prop(env, sphere, pos.data(), kUpright);
}

void ShellGame::play_free_mugs(int env, int ball) const {
  const int cup = target_[env];
  if (engine_.state->elapsed[env] == 0) place_sphere(env, ball, slot_pos(env, cup, BALL_RADIUS));
  if (manipulation_begins(env)) {
    for (int mug = 0; mug < kCups; ++mug) stand_mug(env, mug, mug);
  }
  const Eigen::Vector3d over = mug_pos(env, cup);
  if (is_manipulation(env) && over.z() <= mjcf::kMugRestingHeight + kBallReleaseGap) {
    place_sphere(env, ball, {over.x(), over.y(), BALL_RADIUS});
  }
}

// --- success and info ---

void ShellGame::conclude(int env, const Verdict& verdict) const {
  for (int i = 0; i < 3; ++i) {
    offset_.row(env)[i] = verdict.obj_to_goal[i];
    obj_to_goal_pos_.row(env)[i] = static_cast<float>(verdict.obj_to_goal[i]);
  }
  is_obj_placed_[env] = verdict.placed ? 1 : 0;
  is_robot_static_[env] = verdict.still ? 1 : 0;
  const bool success = verdict.placed && verdict.still && verdict.fair && is_manipulation(env);
  engine_.success[env] = success ? 1 : 0;
  reward_dict_.publish(env);
}

double ShellGame::arm_speed(int env) const {
  return Eigen::Map<const ArmVector>(engine_.state->qvel.row(env)).norm();
}

int ShellGame::chosen_slot(int env, bool blind) const {
  if (!blind) return engine_.oracle_info[env];
  const State& state = *engine_.state;
  RandomStream random(state.seed[env], state.episode[env], kPurposeBlindGuess);
  return random.integer(0, kCups - 1);
}

float* ShellGame::write_point(const Eigen::Vector3d& point, float* out) {
  return std::transform(point.begin(), point.end(), out,
                        [](double value) { return static_cast<float>(value); });
}

float* ShellGame::write_pose(int env, int prop, float* out) const {
  const auto append = [&out](const double* values, int count) {
    out = std::transform(values, values + count, out,
                         [](double value) { return static_cast<float>(value); });
  };
  append(engine_.state->prop_pos_of(env, prop), 3);
  append(engine_.state->prop_quat_of(env, prop), 4);
  return out;
}

// --- overlay (common 11) ---

void ShellGame::overlay(int env, Overlay& out) const {
  static constexpr std::array<const char*, kCups> kSlotNames = {"Left", "Center", "Right"};
  const auto slot = static_cast<std::size_t>(engine_.oracle_info[env]);
  out.add(OverlayText{{10, 60}, std::string("Target: ") + kSlotNames[slot]});
}

std::vector<std::pair<std::string, std::string>> cue_manipulation_phases() {
  return {{"cue", "elapsed < cue_steps"}, {"manipulation", "elapsed >= cue_steps"}};
}

}  // namespace engram::tasks
