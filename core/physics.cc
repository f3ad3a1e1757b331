#include "core/physics.h"

#include <algorithm>
#include <cmath>

#include "core/composed_step.h"
#include "core/error.h"
#include "core/proximity.h"

namespace engram {
namespace {

// Gaps below which the robot, or an awake prop, wakes a sleeping one. Zero would do: a contact
// needs touching geoms, and the test is made at the configuration that collision is computed for.
// Props may stand a millimetre apart without waking one another.
constexpr double kWakeGap = 0.002;       // m
constexpr double kPropWakeGap = 0.0005;  // m

// A free prop that is slower than this for so many control steps, with nothing that moves near
// it, goes to sleep.
constexpr double kSleepLinearSpeed = 0.005;  // m/s
constexpr double kSleepAngularSpeed = 0.05;  // rad/s
constexpr int kSleepSteps = 5;

// Values beyond this are a diverged state, as in MuJoCo's own checks.
constexpr double kLargestValue = mjMAXVAL;

// Sleeping and hidden props wait above one another, far from everything.
constexpr double kParkingSpacing = 100.0;  // m

bool all_plausible(const double* values, int count) {
  bool good = true;
  for (int i = 0; i < count; ++i) good &= std::abs(values[i]) < kLargestValue;  // false for NaN
  return good;
}

int count_warnings(const mjData& data) {
  int count = 0;
  for (const mjWarningStat& warning : data.warning) count += warning.number;
  return count;
}

bool spheres_near(const Eigen::Vector3d& a, double radius_a, const Eigen::Vector3d& b,
                  double radius_b) {
  const double reach = radius_a + radius_b + kPropWakeGap;
  return (a - b).squaredNorm() <= reach * reach;
}

}  // namespace

// One control step of one environment.
class Physics::Step {
 public:
  Step(const Physics& physics, Workbench& bench, const State& state, int env, const Drive& drive)
      : model_(physics.model_),
        options_(physics.options_),
        bench_(bench),
        state_(state),
        env_(env),
        drive_(drive) {}

  bool run() {
    begin();
    for (int i = 0; i < options_.substeps; ++i) {
      glide(static_cast<double>(i + 1) / options_.substeps);
      if (options_.sleep) {
        composed_substep();
      } else {
        plain_substep();
      }
      if (count_warnings(*data_) != 0) return false;
    }
    if (!all_plausible(data_->qpos, scene_->model->nq) ||
        !all_plausible(data_->qvel, scene_->model->nv)) {
      return false;
    }
    store();
    return true;
  }

 private:
  int num_props() const { return state_.num_props; }
  static std::size_t at(int index) { return static_cast<std::size_t>(index); }
  const PropModel& prop_model(int prop) const { return model_.props()[at(prop)]; }
  bool is_status(int prop, PropStatus status) const {
    return bench_.status[at(prop)] == static_cast<std::uint8_t>(status);
  }
  bool is_awake(int prop) const { return is_status(prop, PropStatus::kAwake); }
  const PropSlot& slot_of(int prop) const { return scene_->slots[at(bench_.slot[at(prop)])]; }

  // --- choosing and loading scenes ---

  void begin() {
    std::fill(bench_.awake_by_type.begin(), bench_.awake_by_type.end(), 0);
    bench_.obstacles.clear();
    bench_.gliding.clear();
    bool any_awake = false;
    for (int prop = 0; prop < num_props(); ++prop) {
      PropStatus status = state_.status_of(env_, prop);
      locate(prop, state_.prop_pos_of(env_, prop), state_.prop_quat_of(env_, prop));
      if (status == PropStatus::kAsleep && !options_.sleep && prop_model(prop).free) {
        status = PropStatus::kAwake;
      }
      if (status == PropStatus::kAwake && !prop_model(prop).free) {
        status = PropStatus::kAsleep;
        begin_glide(prop);
      }
      bench_.status[at(prop)] = static_cast<std::uint8_t>(status);
      if (status == PropStatus::kAwake) {
        prepare_awake(prop);
        any_awake = true;
      } else if (status == PropStatus::kAsleep && prop_model(prop).tangible()) {
        bench_.obstacles.push_back({bench_.centers[at(prop)], reach_of(prop) + kWakeGap});
      }
    }
    any_awake |= wake_beside_gliding();
    int scene = any_awake ? model_.smallest_scene(bench_.awake_by_type, true)
                          : PhysicsModel::kDynamicsScene;
    if (!options_.sleep) scene = model_.full_scene();
    enter(scene, state_.qpos.row(env_), state_.qvel.row(env_), state_.qacc_warmstart.row(env_));
  }

  // A gliding prop counts with the sphere around its whole way.
  void begin_glide(int prop) {
    bench_.gliding.push_back(prop);
    const Eigen::Map<const Eigen::Vector3d> way(state_.prop_qvel_of(env_, prop));
    bench_.centers[at(prop)] += way / 2;
    std::copy_n(state_.prop_pos_of(env_, prop), 3, bench_.motion[at(prop)].qpos);
  }

  bool is_gliding(int prop) const {
    return std::find(bench_.gliding.begin(), bench_.gliding.end(), prop) != bench_.gliding.end();
  }

  // Radius of the sphere within which a prop may be during this step.
  double reach_of(int prop) const {
    const double radius = prop_model(prop).bounding_radius;
    if (!is_gliding(prop)) return radius;
    return radius + Eigen::Map<const Eigen::Vector3d>(state_.prop_qvel_of(env_, prop)).norm() / 2;
  }

  // Whether a gliding prop comes near a free one.
  bool gliding_near(int prop) const {
    return std::any_of(bench_.gliding.begin(), bench_.gliding.end(), [&](int other) {
      return prop_model(other).tangible() &&
             spheres_near(bench_.centers[at(prop)], prop_model(prop).bounding_radius,
                          bench_.centers[at(other)], reach_of(other));
    });
  }

  // True if a prop woke.
  bool wake_beside_gliding() {
    bool woken = false;
    for (int prop = 0; prop < num_props(); ++prop) {
      const bool sleeping = is_status(prop, PropStatus::kAsleep) && prop_model(prop).free;
      if (!sleeping || !gliding_near(prop)) continue;
      prepare_awake(prop);
      woken = true;
    }
    return woken;
  }

  // Puts gliding props where they are after that part of their way.
  void glide(double part) {
    for (const int prop : bench_.gliding) {
      double* pos = bench_.motion[at(prop)].qpos;
      const double* from = state_.prop_pos_of(env_, prop);
      const double* way = state_.prop_qvel_of(env_, prop);
      for (int i = 0; i < 3; ++i) pos[i] = from[i] + part * way[i];
      const int mocap = scene_->mocap[at(prop)];
      if (mocap >= 0) std::copy_n(pos, 3, data_->mocap_pos + 3 * mocap);
    }
  }

  // Counts a prop among the awake ones, with the motion that its environment remembers.
  void prepare_awake(int prop) {
    bench_.status[at(prop)] = static_cast<std::uint8_t>(PropStatus::kAwake);
    ++bench_.awake_by_type[at(prop_model(prop).type)];
    PropMotion& motion = bench_.motion[at(prop)];
    std::copy_n(state_.prop_pos_of(env_, prop), 3, motion.qpos);
    std::copy_n(state_.prop_quat_of(env_, prop), 4, motion.qpos + 3);
    std::copy_n(state_.prop_qvel_of(env_, prop), 6, motion.qvel);
    std::copy_n(state_.prop_qacc_warmstart.row(env_) + 6 * prop, 6, motion.qacc_warmstart);
  }

  // Loads robot and props into the data of a scene and goes on with that.
  void enter(int scene, const double* qpos, const double* qvel, const double* warmstart) {
    scene_index_ = scene;
    scene_ = &model_.scenes()[at(scene)];
    data_ = bench_.scenes[at(scene)].get();
    std::copy_n(qpos, kRobotJoints, data_->qpos);
    std::copy_n(qvel, kRobotJoints, data_->qvel);
    std::copy_n(warmstart, kRobotJoints, data_->qacc_warmstart);
    if (scene <= PhysicsModel::kRobotScene) return;
    load_kinematic_props();
    load_free_props();
  }

  // From one scene to another in the middle of a step.
  void move_to(int scene) {
    harvest();
    enter(scene, data_->qpos, data_->qvel, data_->qacc_warmstart);
  }

  void load_kinematic_props() {
    for (int prop = 0; prop < num_props(); ++prop) {
      const int mocap = scene_->mocap[at(prop)];
      if (mocap < 0) continue;
      const double parked[3] = {0, 0, -kParkingSpacing * (prop + 1)};
      const bool present = !is_status(prop, PropStatus::kHidden);
      const double* pos =
          is_gliding(prop) ? bench_.motion[at(prop)].qpos : state_.prop_pos_of(env_, prop);
      std::copy_n(present ? pos : parked, 3, data_->mocap_pos + 3 * mocap);
      std::copy_n(state_.prop_quat_of(env_, prop), 4, data_->mocap_quat + 4 * mocap);
    }
  }

  // Awake props take the slots of their types in order; slots that stay empty are parked.
  void load_free_props() {
    int slot = 0;
    const int count = static_cast<int>(scene_->slots.size());
    while (slot < count) {
      const int type = scene_->slots[at(slot)].type;
      for (int prop = 0; prop < num_props(); ++prop) {
        if (!is_awake(prop) || prop_model(prop).type != type) continue;
        bench_.slot[at(prop)] = slot;
        load_slot(slot++, bench_.motion[at(prop)]);
      }
      for (; slot < count && scene_->slots[at(slot)].type == type; ++slot) {
        const PropMotion parked{{0, 0, kParkingSpacing * (slot + 1), 1, 0, 0, 0}, {}, {}};
        load_slot(slot, parked);
      }
    }
  }

  void load_slot(int slot, const PropMotion& motion) const {
    const PropSlot& where = scene_->slots[at(slot)];
    std::copy_n(motion.qpos, 7, data_->qpos + where.qpos);
    std::copy_n(motion.qvel, 6, data_->qvel + where.dof);
    std::copy_n(motion.qacc_warmstart, 6, data_->qacc_warmstart + where.dof);
    std::fill_n(data_->qfrc_applied + where.dof, 6, 0.0);
  }

  // Takes the motion of awake props out of the present scene.
  void harvest() {
    if (scene_index_ <= PhysicsModel::kRobotScene) return;
    for (int prop = 0; prop < num_props(); ++prop) {
      if (!is_awake(prop)) continue;
      const PropSlot& where = slot_of(prop);
      PropMotion& motion = bench_.motion[at(prop)];
      std::copy_n(data_->qpos + where.qpos, 7, motion.qpos);
      std::copy_n(data_->qvel + where.dof, 6, motion.qvel);
      std::copy_n(data_->qacc_warmstart + where.dof, 6, motion.qacc_warmstart);
    }
  }

  // --- substeps ---

  // Weight of awake props, at their centres of mass. The robot is weightless.
  void apply_weights() const {
    for (int prop = 0; prop < num_props(); ++prop) {
      if (!is_awake(prop)) continue;
      const PropModel& about = prop_model(prop);
      const PropSlot& where = slot_of(prop);
      const mjtNum* quat = data_->qpos + where.qpos + 3;
      const Eigen::Vector3d weight(0, 0, -about.mass * model_.gravity());
      const Eigen::Vector3d in_body =
          Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]).conjugate() * weight;
      Eigen::Map<Eigen::Vector3d>(data_->qfrc_applied + where.dof) = weight;
      Eigen::Map<Eigen::Vector3d>(data_->qfrc_applied + where.dof + 3) =
          about.center_of_mass.cross(in_body);
    }
  }

  void plain_substep() const {
    apply_drive(model_.drive_law(), drive_, *data_);
    apply_weights();
    mj_step(scene_->model.get(), data_);
  }

  void composed_substep() {
    compose_kinematics(scene_->model.get(), data_);
    if (scene_index_ == PhysicsModel::kDynamicsScene &&
        !model_.robot_bounds().is_clear(*data_, bench_.obstacles)) {
      move_to(PhysicsModel::kRobotScene);
      compose_kinematics(scene_->model.get(), data_);
    }
    if (scene_index_ != PhysicsModel::kDynamicsScene) {
      while (wake_what_is_near()) compose_kinematics(scene_->model.get(), data_);
    }
    apply_drive(model_.drive_law(), drive_, *data_);
    if (scene_index_ > PhysicsModel::kRobotScene) apply_weights();
    PairSieve& sieve = bench_.sieves[at(scene_index_)];
    compose_dynamics(scene_->model.get(), data_, sieve.near_pairs(*data_));
  }

  // --- waking and sleeping ---

  // Wakes sleeping props that the robot or an awake prop could touch, and brings kinematic props
  // into the scene that the robot could touch. True if the scene changed.
  bool wake_what_is_near() {
    locate_awake();
    const double lowest = lowest_reach();
    bool kinematic = scene_->has_kinematic_props;
    bool changed = false;
    for (int prop = 0; prop < num_props(); ++prop) {
      if (!is_status(prop, PropStatus::kAsleep) || !prop_model(prop).tangible()) continue;
      const bool free = prop_model(prop).free;
      if (!free && kinematic) continue;
      if (!robot_near(prop, lowest) && !(free && awake_prop_near(prop))) continue;
      if (!changed) harvest();
      changed = true;
      if (free) prepare_awake(prop);
      kinematic = true;  // awake props meet kinematic ones too
    }
    if (changed) {
      enter(model_.smallest_scene(bench_.awake_by_type, kinematic), data_->qpos, data_->qvel,
            data_->qacc_warmstart);
    }
    return changed;
  }

  void locate(int prop, const double* pos, const double* quat) {
    Frame& frame = bench_.frames[at(prop)];
    frame = make_frame(pos, quat);
    bench_.centers[at(prop)] = frame.pos + frame.axes * prop_model(prop).bounding_center;
  }

  // Where awake props are now.
  void locate_awake() {
    if (scene_index_ <= PhysicsModel::kRobotScene) return;
    for (int prop = 0; prop < num_props(); ++prop) {
      if (!is_awake(prop)) continue;
      const mjtNum* qpos = data_->qpos + slot_of(prop).qpos;
      locate(prop, qpos, qpos + 3);
    }
  }

  // Lowest height that a part of the robot may reach: a cheap first test, since props lie low and
  // the robot is above them most of the time.
  double lowest_reach() const {
    double lowest = 1e9;
    for (const int geom : model_.reach_geoms()) {
      lowest = std::min(lowest, data_->geom_xpos[3 * geom + 2] - scene_->model->geom_rbound[geom]);
    }
    return lowest;
  }

  bool robot_near(int prop, double lowest) const {
    const Eigen::Vector3d& center = bench_.centers[at(prop)];
    const double radius = reach_of(prop) + kWakeGap;
    if (center.z() + radius < lowest) return false;
    for (std::size_t i = 0; i < model_.reach_geoms().size(); ++i) {
      const int geom = model_.reach_geoms()[i];
      if (!sphere_reaches_geom(*scene_->model, *data_, geom, center, radius)) continue;
      if (is_gliding(prop) ||
          parts_near(std::span(&model_.reach_boxes()[i], 1), geom_frame(*data_, geom),
                     prop_model(prop).parts, bench_.frames[at(prop)], kWakeGap)) {
        return true;
      }
    }
    return false;
  }

  bool props_near(int prop, int other) const {
    return spheres_near(bench_.centers[at(prop)], prop_model(prop).bounding_radius,
                        bench_.centers[at(other)], prop_model(other).bounding_radius) &&
           parts_near(prop_model(prop).parts, bench_.frames[at(prop)], prop_model(other).parts,
                      bench_.frames[at(other)], kPropWakeGap);
  }

  bool awake_prop_near(int prop) const {
    for (int other = 0; other < num_props(); ++other) {
      if (is_awake(other) && props_near(prop, other)) return true;
    }
    return false;
  }

  // Puts props to sleep that have rested long enough beside nothing that moves.
  void put_to_sleep() {
    const double lowest = lowest_reach();
    std::uint8_t* slow = state_.prop_slow_steps.row(env_);
    for (int prop = 0; prop < num_props(); ++prop) {
      if (!is_awake(prop)) continue;
      const bool resting =
          prop_is_static(state_, env_, prop, kSleepLinearSpeed, kSleepAngularSpeed) &&
          !robot_near(prop, lowest) && !gliding_near(prop);
      slow[prop] = resting ? static_cast<std::uint8_t>(std::min(slow[prop] + 1, kSleepSteps))
                           : std::uint8_t{0};
    }
    while (share_slow_steps(slow)) continue;
    for (int prop = 0; prop < num_props(); ++prop) {
      if (!is_awake(prop) || slow[prop] < kSleepSteps) continue;
      const Eigen::Vector3d pos = Eigen::Map<Eigen::Vector3d>(state_.prop_pos_of(env_, prop));
      const Eigen::Vector4d quat = Eigen::Map<Eigen::Vector4d>(state_.prop_quat_of(env_, prop));
      state_.place_prop(env_, prop, pos.data(), quat.data(), PropStatus::kAsleep);
    }
  }

  // Awake props near one another count as slow as long as the most restless of them, so that they
  // fall asleep together: one that stayed awake would wake the others. True if a count changed.
  bool share_slow_steps(std::uint8_t* slow) const {
    bool changed = false;
    for (int prop = 0; prop < num_props(); ++prop) {
      for (int other = 0; other < num_props(); ++other) {
        if (slow[prop] <= slow[other] || !is_awake(prop) || !is_awake(other)) continue;
        if (!props_near(prop, other)) continue;
        slow[prop] = slow[other];
        changed = true;
      }
    }
    return changed;
  }

  // --- storing ---

  void store() {
    std::copy_n(data_->qpos, kRobotJoints, state_.qpos.row(env_));
    std::copy_n(data_->qvel, kRobotJoints, state_.qvel.row(env_));
    std::copy_n(data_->qacc_warmstart, kRobotJoints, state_.qacc_warmstart.row(env_));
    if (num_props() == 0) return;
    store_glides();
    std::fill_n(state_.finger_force.row(env_), 6 * num_props(), 0.0);
    if (scene_index_ <= PhysicsModel::kRobotScene) return;
    harvest();
    for (int prop = 0; prop < num_props(); ++prop) {
      if (!is_awake(prop)) continue;
      const PropMotion& motion = bench_.motion[at(prop)];
      std::copy_n(motion.qpos, 3, state_.prop_pos_of(env_, prop));
      std::copy_n(motion.qpos + 3, 4, state_.prop_quat_of(env_, prop));
      std::copy_n(motion.qvel, 6, state_.prop_qvel_of(env_, prop));
      std::copy_n(motion.qacc_warmstart, 6, state_.prop_qacc_warmstart.row(env_) + 6 * prop);
      state_.prop_status.row(env_)[prop] = bench_.status[at(prop)];
    }
    store_finger_forces();
    if (options_.sleep) put_to_sleep();
  }

  // Gliding props have arrived.
  void store_glides() const {
    for (const int prop : bench_.gliding) {
      std::copy_n(bench_.motion[at(prop)].qpos, 3, state_.prop_pos_of(env_, prop));
      std::fill_n(state_.prop_qvel_of(env_, prop), 6, 0.0);
      state_.prop_status.row(env_)[prop] = static_cast<std::uint8_t>(PropStatus::kAsleep);
    }
  }

  // Sums the contact forces between each prop and each finger, as the prop exerts them.
  void store_finger_forces() const {
    const mjModel& model = *scene_->model;
    for (int i = 0; i < data_->ncon; ++i) {
      const mjContact& contact = data_->contact[i];
      if (contact.efc_address < 0) continue;
      const int bodies[2] = {model.geom_bodyid[contact.geom1], model.geom_bodyid[contact.geom2]};
      const int slot =
          std::max(scene_->slot_of_body[at(bodies[0])], scene_->slot_of_body[at(bodies[1])]);
      for (int finger = 0; finger < kFingers && slot >= 0; ++finger) {
        const int body = model_.finger_bodies()[finger];
        if (body != bodies[0] && body != bodies[1]) continue;
        mjtNum wrench[6];  // in the contact's frame, on the second body
        mj_contactForce(&model, data_, i, wrench);
        const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> frame(contact.frame);
        const Eigen::Vector3d force =
            frame.transpose() * Eigen::Vector3d(wrench[0], wrench[1], wrench[2]);
        Eigen::Map<Eigen::Vector3d> sum(state_.finger_force.row(env_) + 6 * prop_in_slot(slot) +
                                        3 * finger);
        sum += body == bodies[1] ? force : Eigen::Vector3d(-force);
      }
    }
  }

  int prop_in_slot(int slot) const {
    int prop = 0;
    while (!is_awake(prop) || bench_.slot[at(prop)] != slot) ++prop;
    return prop;
  }

  const PhysicsModel& model_;
  const PhysicsOptions& options_;
  Workbench& bench_;
  const State& state_;
  int env_;
  const Drive& drive_;
  int scene_index_ = 0;
  const SceneModel* scene_ = nullptr;
  mjData* data_ = nullptr;
};

void apply_drive(const DriveLaw& law, const Drive& drive, mjData& data) {
  for (std::size_t joint = 0; joint < kRobotJoints; ++joint) {
    const bool arm = joint < kArmJoints;
    double force = -law.damping * data.qvel[joint];
    if (!arm || !drive.velocity_mode) {
      force += law.stiffness * (drive.target[joint] - data.qpos[joint]);
    }
    if (arm) force += law.damping * drive.velocity[joint];
    data.ctrl[joint] = std::clamp(force, -law.limit, law.limit);
  }
}

Physics::Physics(const PhysicsModel& model, const PhysicsOptions& options, int workers)
    : model_(model), options_(options) {
  const std::size_t props = model.props().size();
  workbenches_.resize(static_cast<std::size_t>(workers));
  for (Workbench& bench : workbenches_) {
    for (const SceneModel& scene : model.scenes()) {
      bench.scenes.push_back(make_data(*scene.model));
      bench.sieves.emplace_back(*scene.model);
    }
    bench.status.resize(props);
    bench.slot.resize(props);
    bench.awake_by_type.resize(static_cast<std::size_t>(model.num_types()));
    bench.motion.resize(props);
    bench.frames.resize(props);
    bench.centers.resize(props);
    bench.obstacles.reserve(props);
    bench.gliding.reserve(props);
  }
}

bool Physics::step(const State& state, int env, int worker, const Drive& drive) {
  if (options_.substeps == 0) return true;
  Workbench& bench = workbenches_[static_cast<std::size_t>(worker)];
  const MujocoScope scope;
  bool good = false;
  try {
    good = Step(*this, bench, state, env, drive).run();
  } catch (const Error&) {
    // MuJoCo gave up in the middle of a step; nothing has been stored.
  }
  if (!good) {
    for (std::size_t i = 0; i < bench.scenes.size(); ++i) {
      mj_resetData(model_.scenes()[i].model.get(), bench.scenes[i].get());
    }
  }
  return good;
}

void Physics::update_tcp(const State& state, int env) const {
  const Pose pose = model_.arm().forward(state.qpos.row(env));
  Eigen::Map<Eigen::Vector3d>(state.tcp_pos.row(env)) = pose.pos;
  double* quat = state.tcp_quat.row(env);
  quat[0] = pose.quat.w();
  quat[1] = pose.quat.x();
  quat[2] = pose.quat.y();
  quat[3] = pose.quat.z();
}

}  // namespace engram
