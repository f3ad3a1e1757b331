#include "core/scene/physics_model.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/index.h"
#include "core/scene/robot_model_loader.h"

namespace engram {
namespace {

[[noreturn]] void refuse(const std::string& why) { throw Error(Error::kInternal, why); }

int body_named(const mjModel& model, const std::string& name) {
  const int body = mj_name2id(&model, mjOBJ_BODY, name.c_str());
  if (body < 0) refuse("scene without a body named '" + name + "'");
  return body;
}

// Bounds the colliding geoms of a body, in its frame: by a sphere, whose centre is that of their
// bounding box, and each geom by a box.
void bound_prop(const mjModel& model, int body, PropModel& prop) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9);
  Eigen::Vector3d high = Eigen::Vector3d::Constant(-1e9);
  const int first = model.body_geomadr[body];
  const int last = first + model.body_geomnum[body];
  for (int geom = first; geom < last; ++geom) {
    const Eigen::Map<const Eigen::Vector3d> pos(model.geom_pos + 3 * geom);
    low = low.cwiseMin((pos.array() - model.geom_rbound[geom]).matrix());
    high = high.cwiseMax((pos.array() + model.geom_rbound[geom]).matrix());
  }
  prop.bounding_center.setZero();
  if (first < last) prop.bounding_center = 0.5 * (low + high);
  for (int geom = first; geom < last; ++geom) {
    const Eigen::Map<const Eigen::Vector3d> pos(model.geom_pos + 3 * geom);
    prop.bounding_radius = std::max(prop.bounding_radius,
                                    (pos - prop.bounding_center).norm() + model.geom_rbound[geom]);
    prop.parts.push_back(enclose_geom(model, geom));
  }
}

// Reads the drive that all nine joints share, and their limits. Throws Error for scenes in which
// the drives differ.
RobotParams read_robot_params(const mjModel& model) {
  if (model.nuser_actuator < 3) refuse("drives without stiffness, damping and force limit");
  RobotParams params;
  const mjtNum* const first = model.actuator_user;
  params.drive = {first[0], first[1], first[2]};
  params.timestep = model.opt.timestep;
  for (int i = 0; i < kRobotJoints; ++i) {
    const mjtNum* const drive = first + i * model.nuser_actuator;
    const bool same = std::equal(first, first + 3, drive) && model.actuator_trnid[2 * i] == i;
    if (!same) refuse("the robot's joints need the same drive and actuators in joint order");
    params.lower[i] = model.jnt_range[2 * i];
    params.upper[i] = model.jnt_range[2 * i + 1];
  }
  params.single = rounded<RobotParamsOf>(params);
  return params;
}

// Throws Error unless the robot's joints come first, with one coordinate each.
void validate_joints(const mjModel& model) {
  if (model.nu != kRobotJoints || model.nv < kRobotJoints) {
    refuse("scene without the nine driven joints of the robot");
  }
  for (int i = 0; i < kRobotJoints; ++i) {
    const int type = model.jnt_type[i];
    if (model.jnt_dofadr[i] != i || (type != mjJNT_HINGE && type != mjJNT_SLIDE)) {
      refuse("the robot's nine joints are not the scene's first");
    }
  }
}

// Removes from the model what the engine simulates: drives, limits, coupling, damping and rotor
// inertia of the robot's joints, and gravity.
void release_robot(mjModel& model) {
  model.opt.gravity[2] = 0;
  for (int i = 0; i < kRobotJoints; ++i) {
    model.jnt_limited[i] = 0;
    model.dof_armature[i] = 0;
    model.dof_damping[i] = 0;
  }
  std::fill_n(model.actuator_gainprm, model.nu * mjNGAIN, 0.0);
  std::fill_n(model.actuator_biasprm, model.nu * mjNBIAS, 0.0);
  std::fill_n(model.tendon_stiffness, model.ntendon, 0.0);
}

}  // namespace

PhysicsModel::PhysicsModel(const SceneSpec& source)
    : full_(compile_model(source.compose_all())),
      robot_(compile_model(source.compose({}, RobotDetail::kCollision))),
      arm_(*full_),
      gravity_(-full_->opt.gravity[2]) {
  validate_joints(*full_);
  robot_params_ = read_robot_params(*full_);
  release_robot(*full_);
  release_robot(*robot_);
  read_props(source);
  collision_ = CollisionScene(*full_, source.props);
  find_reach_shapes();
  robot_bounds_ = RobotBounds(*robot_, *full_);
  robot_model_ = load_robot_model(*robot_);
  std::copy(robot_bounds_.lever_arms().begin(), robot_bounds_.lever_arms().end(),
            robot_model_.lever_arms);
  robot_model_.single = rounded<RobotModelOf>(robot_model_);
}

void PhysicsModel::read_props(const SceneSpec& source) {
  for (const std::string& name : source.props) {
    const int body = body_named(*full_, name);
    PropModel prop;
    prop.name = name;
    prop.free = full_->body_mocapid[body] < 0;
    if (prop.free) {
      const int joint = full_->body_jntadr[body];
      if (joint < 0 || full_->jnt_type[joint] != mjJNT_FREE) {
        refuse("prop '" + name + "' has neither a free joint nor a mocap body");
      }
      prop.body = FreeBody(*full_, body);
    }
    prop.mass = full_->body_mass[body];
    bound_prop(*full_, body, prop);
    props_.push_back(std::move(prop));
  }
}

void PhysicsModel::find_reach_shapes() {
  for (const ShapePair& pair : collision_.shape_pairs()) {
    const CollisionBody& a = collision_.bodies()[at(collision_.shapes()[at(pair.a)].body)];
    const CollisionBody& b = collision_.bodies()[at(collision_.shapes()[at(pair.b)].body)];
    if (a.kind == BodyKind::kLink && b.prop >= 0) reach_shapes_.push_back(pair.a);
  }
  std::sort(reach_shapes_.begin(), reach_shapes_.end());
  reach_shapes_.erase(std::unique(reach_shapes_.begin(), reach_shapes_.end()), reach_shapes_.end());
  for (const int shape : reach_shapes_) {
    reach_boxes_.push_back(enclose_geom(*full_, collision_.shapes()[at(shape)].geom));
    reach_boxes_.back().frame = {};
  }
}

}  // namespace engram
