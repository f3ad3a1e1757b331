#include "core/sim/state_transfer.h"

#include <bit>
#include <cmath>
#include <cstdint>

namespace engram {
namespace {

// Values beyond this are a diverged state, as in MuJoCo's own checks.
constexpr double kLargestValue = mjMAXVAL;
// rad, m: joints beyond it have no sines in single precision (core/math/sine_cosine.h).
constexpr double kLargestJoint = 1e4;

// Tests that the absolute values of all numbers are below a limit. Without their sign bits,
// doubles are ordered like the integers of the same bits, and NaN is above all numbers; a value
// that is too large makes the difference negative, which sets its top bit. The compiler vectorises
// this loop, but not one that compares doubles.
bool all_plausible(const double* values, int count, double limit = kLargestValue) {
  constexpr std::uint64_t kSign = std::uint64_t{1} << 63;
  std::uint64_t differences = 0;
  for (int i = 0; i < count; ++i) {
    const std::uint64_t magnitude = std::bit_cast<std::uint64_t>(values[i]) & ~kSign;
    differences |= std::bit_cast<std::uint64_t>(limit) - 1 - magnitude;
  }
  return (differences & kSign) == 0;
}

}  // namespace

bool StateTransfer::state_is_plausible() const {
  const int count = step_.num_props();
  return all_plausible(state_.qpos.row(env_), kRobotJoints, kLargestJoint) &&
         all_plausible(state_.qvel.row(env_), kRobotJoints) &&
         all_plausible(state_.prop_pos.row(env_), 3 * count) &&
         all_plausible(state_.prop_quat.row(env_), 4 * count) &&
         all_plausible(state_.prop_qvel.row(env_), 6 * count);
}

bool StateTransfer::is_plausible(const JointArray& qpos, const JointArray& qvel) const {
  bool good = all_plausible(qpos.data(), kRobotJoints, kLargestJoint) &&
              all_plausible(qvel.data(), kRobotJoints);
  for (const int prop : step_.awake()) {
    const FreeBodyState& motion = workspace_.motion[at(prop)];
    good = good && all_plausible(motion.center.data(), 3) &&
           all_plausible(motion.quat.coeffs().data(), 4) &&
           all_plausible(motion.linear.data(), 3) && all_plausible(motion.angular.data(), 3);
  }
  return good;
}

void StateTransfer::begin(bool sleep) {
  workspace_.awake.clear();
  workspace_.moving.clear();
  for (int prop = 0; prop < step_.num_props(); ++prop) {
    const PropStatus status = state_.status_of(env_, prop);
    workspace_.status[at(prop)] = status;
    if (step_.prop_model(prop).free) {
      const bool present = status != PropStatus::kHidden;
      if (status == PropStatus::kAwake || (present && !sleep)) step_.wake(prop);
    } else if (status == PropStatus::kAwake) {
      workspace_.moving.push_back(prop);
      workspace_.status[at(prop)] = PropStatus::kAsleep;
    }
  }
}

void StateTransfer::load_contacts() {
  if (contacts_loaded_) return;
  contacts_loaded_ = true;
  workspace_.memory.pairs.clear();
  const int shape_pairs = static_cast<int>(step_.model.collision().shape_pairs().size());
  for (int i = 0; i < state_.num_contact_pairs; ++i) {
    if (StoredPair::is_empty(pair_ids(i))) break;
    ContactPair& pair = workspace_.memory.pairs.emplace_back();
    if (!load_pair(pair_ids(i), pair_values(i), shape_pairs, pair)) {
      workspace_.memory.pairs.pop_back();
    }
  }
}

void StateTransfer::move_kinematic_props(int substep, int substeps) {
  const double part = static_cast<double>(substep) / substeps;
  workspace_.moves_per_second = 1 / (substeps * step_.model.robot_params().timestep);
  for (const int prop : step_.moving()) {
    const double* from = state_.prop_pos_of(env_, prop);
    const double* displacement = step_.displacement_of(prop);
    Vec3& pos = workspace_.moving_pos[at(prop)];
    for (int i = 0; i < 3; ++i) pos[i] = from[i] + part * displacement[i];
  }
}

// --- bodies ---

void StateTransfer::pose_links(const RobotPose& robot, const BroadPhase& broad_phase, int lane) {
  const std::vector<CollisionBody>& bodies = step_.model.collision().bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const CollisionBody& body = bodies[i];
    if (body.kind != BodyKind::kLink) continue;
    workspace_.bodies.frames[i] = workspace_.is_link[i] != 0 ? robot.links[at(body.attachment.link)]
                                                             : carried(robot, body.attachment);
    workspace_.bodies.speeds[i] = broad_phase.speed(lane, static_cast<int>(i));
  }
}

void StateTransfer::pose_props(BroadPhase& broad_phase, int lane) {
  const BodyStates& bodies = workspace_.bodies;
  for (int prop = 0; prop < step_.num_props(); ++prop) {
    const int body = step_.model.collision().body_of_prop(prop);
    if (body < 0) continue;
    const bool changed = step_.prop_model(prop).free ? pose_free(prop) : pose_kinematic(prop);
    if (changed) broad_phase.put(lane, body, bodies.frames[at(body)], bodies.speeds[at(body)]);
  }
  resting_posed_ = true;
  broad_phase.enter(lane, bodies.presence);
}

// Returns whether its pose is another than in the last substep.
bool StateTransfer::pose_kinematic(int prop) {
  const bool moving = step_.is_moving(prop);
  if (resting_posed_ && !moving) return false;
  const auto body = at(step_.model.collision().body_of_prop(prop));
  BodyStates& bodies = workspace_.bodies;
  const bool hidden = workspace_.status[at(prop)] == PropStatus::kHidden;
  bodies.presence[body] = hidden ? BodyPresence::kAbsent : BodyPresence::kPresent;
  bodies.frames[body] = make_frame(state_.prop_pos_of(env_, prop), state_.prop_quat_of(env_, prop));
  bodies.kinematic_velocities[body] = Vec3::Zero();
  bodies.speeds[body] = 0;
  if (!moving) return true;
  const double per_second = workspace_.moves_per_second;
  bodies.frames[body].pos = workspace_.moving_pos[at(prop)];
  bodies.kinematic_velocities[body] =
      per_second * Eigen::Map<const Vec3>(step_.displacement_of(prop));
  bodies.speeds[body] = bodies.kinematic_velocities[body].norm();
  return true;
}

// Returns whether it is simulated.
bool StateTransfer::pose_free(int prop) {
  const auto body = at(step_.model.collision().body_of_prop(prop));
  BodyStates& bodies = workspace_.bodies;
  if (!step_.is_awake(prop)) {
    bodies.presence[body] = step_.is_asleep(prop) ? BodyPresence::kResting : BodyPresence::kAbsent;
    bodies.speeds[body] = 0;
    return false;
  }
  const FreeBodyState& motion = workspace_.motion[at(prop)];
  Frame& frame = bodies.frames[body];
  frame.axes = motion.quat.toRotationMatrix();
  frame.pos = motion.center - frame.axes * step_.prop_model(prop).body.center();
  bodies.presence[body] = BodyPresence::kPresent;
  bodies.speeds[body] = step_.prop_speed(prop);
  return true;
}

// --- into the columns ---

void StateTransfer::store(const JointArray& qpos, const JointArray& qvel) {
  std::copy_n(qpos.begin(), kRobotJoints, state_.qpos.row(env_));
  std::copy_n(qvel.begin(), kRobotJoints, state_.qvel.row(env_));
  if (step_.num_props() > 0) {
    std::fill_n(state_.finger_force.row(env_), 6 * step_.num_props(), 0.0);
  }
  for (const int prop : step_.moving()) {
    Eigen::Map<Vec3>{state_.prop_pos_of(env_, prop)} = workspace_.moving_pos[at(prop)];
    std::fill_n(state_.prop_qvel_of(env_, prop), 6, 0.0);
    state_.prop_status.row(env_)[prop] = static_cast<std::uint8_t>(PropStatus::kAsleep);
  }
  for (const int prop : step_.awake()) {
    step_.prop_model(prop).body.store(workspace_.motion[at(prop)], state_.prop_pos_of(env_, prop),
                                      state_.prop_quat_of(env_, prop),
                                      state_.prop_qvel_of(env_, prop));
    state_.prop_status.row(env_)[prop] = static_cast<std::uint8_t>(PropStatus::kAwake);
  }
  if (contacts_loaded_) {
    store_contacts();
  } else {
    keep_resting_contacts();
  }
}

void StateTransfer::store_contacts() const {
  const CollisionScene& scene = step_.model.collision();
  const auto prop_of = [&](int shape) {
    return scene.bodies()[at(scene.shapes()[at(shape)].body)].prop;
  };
  int count = 0;
  for (const ContactPair& pair : workspace_.memory.pairs) {
    if (count == state_.num_contact_pairs) return;
    const ShapePair& shapes = scene.shape_pairs()[at(pair.shape_pair)];
    store_pair(pair, prop_of(shapes.a), prop_of(shapes.b), pair_ids(count), pair_values(count));
    ++count;
  }
  for (; count < state_.num_contact_pairs; ++count) {
    if (StoredPair::is_empty(pair_ids(count))) return;
    clear_pair(count);
  }
}

void StateTransfer::clear_pair(int pair) const {
  std::fill_n(pair_ids(pair), StoredPair::kInts, 0);
  std::fill_n(pair_values(pair), StoredPair::kFloats, 0.0F);
}

// Nothing came near anything: what a search would have forgotten is forgotten.
void StateTransfer::keep_resting_contacts() const {
  const auto present = [this](std::int32_t stored) {
    return stored == 0 || workspace_.status[at(stored - 1)] != PropStatus::kHidden;
  };
  const auto rests = [this](std::int32_t stored) {
    return stored > 0 && step_.prop_model(stored - 1).free && step_.is_asleep(stored - 1);
  };
  int kept = 0;
  for (int i = 0; i < state_.num_contact_pairs; ++i) {
    const std::int32_t* const ids = pair_ids(i);
    if (StoredPair::is_empty(ids)) return;
    const std::int32_t a = ids[StoredPair::kPropA];
    const std::int32_t b = ids[StoredPair::kPropB];
    const bool keep = present(a) && present(b) && (rests(a) || rests(b));
    if (keep && kept == i) {
      ++kept;
      continue;
    }
    if (keep) {
      std::copy_n(ids, StoredPair::kInts, pair_ids(kept));
      std::copy_n(pair_values(i), StoredPair::kFloats, pair_values(kept));
      ++kept;
    }
    clear_pair(i);
  }
}

void StateTransfer::store_finger_forces(int lane, const ContactBlock& block) const {
  const double per_second = 1 / step_.model.robot_params().timestep;
  workspace_.contacts.for_finger_impulses(
      lane, block, [&](int prop, int finger, const Vec3& impulse) {
        Eigen::Map<Vec3> sum(state_.finger_force.row(env_) + 6 * prop + 3 * finger);
        sum += per_second * impulse;
      });
}

}  // namespace engram
