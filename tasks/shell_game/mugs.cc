#include "tasks/shell_game/mugs.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/index.h"
#include "core/base/join.h"
#include "mjcf/mug.h"
#include "tasks/common/footprint.h"

namespace engram::tasks {
namespace {

constexpr std::array<const char*, kCups> kNames = {"mug_left", "mug_center", "mug_right"};
constexpr double kBaseRange = 0.1;  // m

mjcf::Prop standing_mug(int slot, const ShellGameParams& params,
                        const MugOrientation& orientation) {
  mjcf::Prop mug = mjcf::mug(kNames[at(slot)], orientation.handle_yaw, params.MUG_SCALE);
  mug.pos = {0, (slot - 1) * params.MIN_DIST, params.resting_height()};
  mug.quat = orientation.quat;
  return mug;
}

// Tip of the axis of a mug so tilted that cameras see into it: a cosine, -1 upside down.
constexpr double kLookInside = -0.75;

// 0 up to `low`, 1 from `high` on, smooth in between.
double rising(double value, double low, double high) {
  const double t = std::clamp((value - low) / (high - low), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// Between two mugs side by side, or minus their overlap, m.
double gap_between(mjcf::Prop mug, double slot_distance) {
  std::erase_if(mug.geoms, [](const mjcf::Geom& part) { return !part.collides; });
  const Footprint footprint = footprint_of(mug);
  double least = slot_distance;
  for (const FootprintPart& one : footprint.parts) {
    for (const FootprintPart& other : footprint.parts) {
      least = std::min(least, part_clearance(one, other, {0, slot_distance}));
    }
  }
  return least;
}

}  // namespace

// Half turns about horizontal axes at 26.57 and 68.20 degrees.
const MugOrientation kUpsideDown{mjcf::kMugHandleYaw, {0, 0.894427190999916, 0.447213595499958, 0}};
const MugOrientation kHandleTowardsRobot{0, {0, 0.371390676354104, 0.928476690885259, 0}};
// Turns by c = 2.3, 2.5, 2.7: at 66.50, 68.20 and 69.68 degrees.
const std::array<MugOrientation, 3> kHandleTurns = {{
    {mjcf::kMugHandleYaw, {0, 0.398726111414450, 0.917070056253235, 0}, 0.535915348071814},
    {mjcf::kMugHandleYaw, {0, 0.371390676354104, 0.928476690885259, 0}, 0.595157274930067},
    {mjcf::kMugHandleYaw, {0, 0.347314355823594, 0.937748760723702, 0}, 0.646758725132916},
}};

void check_mugs(const ShellGameParams& params, const MugOrientation& orientation, double room) {
  const double gap = gap_between(standing_mug(0, params, orientation), params.MIN_DIST);
  if (gap < room) {
    throw Error(Error::kInvalidArgument, "cups of MUG_SCALE " + shortest(params.MUG_SCALE) +
                                             " do not stand apart: MIN_DIST " +
                                             shortest(params.MIN_DIST) + " m leaves " +
                                             in_millimetres(gap) + " between two, at least " +
                                             in_millimetres(room) + " allowed");
  }
  const double hidden = mjcf::kMugHides * params.mug_ratio();
  if (params.BALL_RADIUS > hidden) {
    refuse_constant("BALL_RADIUS", shortest(params.BALL_RADIUS),
                    "at most " + in_millimetres(hidden) + " allowed: a cup of MUG_SCALE " +
                        shortest(params.MUG_SCALE) + " would not hide the ball");
  }
}

VariableHandle Mugs::declare_base(RandomVariables list) {
  return list.add({"base", 2, false, -kBaseRange, kBaseRange, "m", "x, y of the center slot"});
}

Mugs::Mugs(mjcf::Scene& scene, const ShellGameParams& params,
           std::span<const MugOrientation> orientations)
    : orientations_(orientations.begin(), orientations.end()),
      slot_distance_(params.MIN_DIST),
      resting_height_(params.resting_height()),
      hiding_radius_(mjcf::kMugHides * params.mug_ratio()) {
  for (int slot = 0; slot < kCups; ++slot) {
    scene.props.push_back(standing_mug(slot, params, orientations_[0]));
  }
}

void Mugs::bind(const Bindings& bindings) {
  engine_ = bindings;
  base_ = bindings.memory->add<double>("base", 2, "m");
  if (orientations_.size() == 1) return;
  orientation_of_ = bindings.memory->add<std::int32_t>("mug_stance");
  bindings.memory->limit("mug_stance", 0, static_cast<int>(orientations_.size()) - 1);
}

void Mugs::reset(const Episode& episode, const VariableHandle& base) const {
  const int env = episode.env();
  if (const double* pinned = base.pinned(episode)) {
    std::copy_n(pinned, 2, base_.row(env));
  } else {
    RandomStream random = base.stream(episode);
    for (int i = 0; i < 2; ++i) base_.row(env)[i] = random.uniform(-kBaseRange, kBaseRange);
  }
  for (int mug = 0; mug < kCups; ++mug) {
    const Eigen::Vector3d pos = slot_pos(env, mug, resting_height_ + HEIGHT_OFFSET);
    engine_.state->place_prop(env, mug, pos.data(), orientation(env).quat.data(),
                              PropStatus::kHidden);
  }
}

void Mugs::choose_orientation(int env, int index) const {
  orientation_of_[env] = index;
  const State& state = *engine_.state;
  for (int mug = 0; mug < kCups; ++mug) {
    const Eigen::Vector3d there = pos(env, mug);
    state.place_prop(env, mug, there.data(), orientation(env).quat.data(),
                     state.status_of(env, mug));
  }
}

Eigen::Vector3d Mugs::standing_pos(int env, int slot) const {
  return slot_pos(env, slot, resting_height_);
}

void Mugs::stand(int env, int mug, const Eigen::Vector3d& pos) const {
  engine_.state->place_prop(env, mug, pos.data(), orientation(env).quat.data());
}

bool Mugs::hides(int env, int mug) const {
  constexpr double kLevel = 0.995;  // cosine of a mug's tilt that lets nothing be seen
  const State& state = *engine_.state;
  if (state.status_of(env, mug) == PropStatus::kHidden) return false;
  return state.prop_pos_of(env, mug)[2] < resting_height_ + kLiftThatShows &&
         std::abs(axis_height(env, mug)) > kLevel;
}

bool Mugs::encloses(int env, int mug) const {
  return engine_.state->status_of(env, mug) != PropStatus::kHidden &&
         axis_height(env, mug) < kLookInside;
}

Eigen::Vector3d Mugs::pos_inside(int env, int mug, double radius) const {
  constexpr double kLying = -0.25;  // cosines: from there on the ball lies on the wall,
  constexpr double kMouthUp = 0.5;  // and on the foot
  constexpr double kFoot = 0.005;   // m thick, at most
  const double* q = engine_.state->prop_quat_of(env, mug);
  const Eigen::Quaterniond turned(q[0], q[1], q[2], q[3]);
  const double axis = axis_height(env, mug);
  const double reach = resting_height_ - radius;
  const double fallen = rising(axis, 0, kMouthUp);
  const Eigen::Vector3d down = turned.conjugate() * -Eigen::Vector3d::UnitZ();
  Eigen::Vector3d inside(down.x(), down.y(), 0);
  if (inside.norm() > 0) inside.normalize();
  inside *= rising(axis, kLookInside, kLying) * std::max(0.0, hiding_radius_ - radius);
  inside.z() = std::lerp(reach, kFoot - reach, fallen);
  return pos(env, mug) + turned * inside;
}

double Mugs::axis_height(int env, int mug) const {
  const double* q = engine_.state->prop_quat_of(env, mug);
  return 1 - 2 * (q[1] * q[1] + q[2] * q[2]);
}

void Mugs::stand_all(int env) const {
  for (int mug = 0; mug < kCups; ++mug) stand(env, mug, mug);
}

}  // namespace engram::tasks
