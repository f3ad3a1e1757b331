#include "core/scene/physics_model.h"

#include <algorithm>
#include <numeric>

#include "core/base/error.h"
#include "core/robot/robot_model_loader.h"

namespace engram {
namespace {

// Most scenes between the robot alone and the whole: enough for any three of about four types, few
// enough to compile in some tens of milliseconds.
constexpr std::size_t kMaxSubsets = 20;

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
  RobotParams params;
  params.drive = {model.actuator_gainprm[0], model.dof_damping[0], model.actuator_forcerange[1]};
  params.timestep = model.opt.timestep;
  for (int i = 0; i < kRobotJoints; ++i) {
    const bool same = model.actuator_gainprm[i * mjNGAIN] == params.drive.stiffness &&
                      model.dof_damping[i] == params.drive.damping &&
                      model.actuator_forcerange[2 * i + 1] == params.drive.limit &&
                      model.actuator_trnid[2 * i] == i;
    if (!same) refuse("the robot's joints need the same drive and actuators in joint order");
    params.lower[i] = model.jnt_range[2 * i];
    params.upper[i] = model.jnt_range[2 * i + 1];
  }
  return params;
}

std::vector<int> all_props(const SceneSpec& source) {
  std::vector<int> all(source.props.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

// `text_model`: the scene with all props, even those of which nothing collides.
std::vector<SceneModel> compile_scenes(const SceneSpec& source, ModelPtr text_model,
                                       const std::vector<PropModel>& props) {
  const std::vector<int> all = all_props(source);
  std::vector<int> free_props;
  std::vector<int> kinematic_props;
  for (const int prop : all) {
    const PropModel& model = props[static_cast<std::size_t>(prop)];
    if (model.tangible()) (model.free ? free_props : kinematic_props).push_back(prop);
  }
  std::vector<SceneModel> scenes;
  const auto add = [&](std::vector<int> subset, RobotDetail detail) {
    std::sort(subset.begin(), subset.end());
    scenes.push_back(compile_scene(source, subset, detail));
  };
  add({}, RobotDetail::kDynamics);
  add({}, RobotDetail::kCollision);
  if (!kinematic_props.empty() && !free_props.empty()) {
    add(kinematic_props, RobotDetail::kCollision);
  }
  for (std::vector<int>& subset : scene_subsets(source, free_props, kMaxSubsets)) {
    subset.insert(subset.end(), kinematic_props.begin(), kinematic_props.end());
    add(std::move(subset), RobotDetail::kCollision);
  }
  std::vector<int> whole = free_props;
  whole.insert(whole.end(), kinematic_props.begin(), kinematic_props.end());
  if (whole.size() == all.size() && !all.empty()) {
    scenes.push_back(make_scene(std::move(text_model), source, all));
  } else if (!whole.empty()) {
    add(std::move(whole), RobotDetail::kCollision);
  }
  return scenes;
}

}  // namespace

PhysicsModel::PhysicsModel(const SceneSpec& source)
    : PhysicsModel(source,
                   compile_model(source.compose(all_props(source), RobotDetail::kCollision))) {}

PhysicsModel::PhysicsModel(const SceneSpec& source, ModelPtr whole) : arm_(*whole) {
  read_text_model(source, *whole);
  scenes_ = compile_scenes(source, std::move(whole), props_);
  robot_bounds_ = RobotBounds(robot(), full());
  robot_model_ = load_robot_model(robot());
  std::copy(robot_bounds_.lever_arms().begin(), robot_bounds_.lever_arms().end(),
            robot_model_.lever_arms);
}

// Reads constants from the text's model, before release_robot() changes the compiled ones.
void PhysicsModel::read_text_model(const SceneSpec& source, const mjModel& whole) {
  gravity_ = -whole.opt.gravity[2];
  if (whole.nu != kRobotJoints) refuse("scene without the nine driven joints of the robot");
  robot_params_ = read_robot_params(whole);
  read_props(source, whole);
  find_reach_geoms(whole);
  finger_bodies_[0] = body_named(whole, "leftfinger");
  finger_bodies_[1] = body_named(whole, "rightfinger");
}

void PhysicsModel::read_props(const SceneSpec& source, const mjModel& whole) {
  if (source.types.size() != source.props.size()) refuse("one type for each prop needed");
  for (std::size_t i = 0; i < source.props.size(); ++i) {
    const int body = body_named(whole, source.props[i]);
    PropModel prop;
    prop.name = source.props[i];
    prop.type = source.types[i];
    prop.free = whole.body_mocapid[body] < 0;
    prop.mass = whole.body_mass[body];
    prop.center_of_mass = Eigen::Map<const Eigen::Vector3d>(whole.body_ipos + 3 * body);
    bound_prop(whole, body, prop);
    num_types_ = std::max(num_types_, prop.type + 1);
    props_.push_back(std::move(prop));
  }
}

void PhysicsModel::find_reach_geoms(const mjModel& whole) {
  std::vector<bool> is_prop(static_cast<std::size_t>(whole.nbody), false);
  for (const PropModel& prop : props_) {
    is_prop[static_cast<std::size_t>(body_named(whole, prop.name))] = true;
  }
  for (int pair = 0; pair < whole.npair; ++pair) {
    const int geoms[2] = {whole.pair_geom1[pair], whole.pair_geom2[pair]};
    for (int i = 0; i < 2; ++i) {
      const int body = whole.geom_bodyid[geoms[i]];
      const int other = whole.geom_bodyid[geoms[1 - i]];
      if (body != 0 && !is_prop[static_cast<std::size_t>(body)] &&
          is_prop[static_cast<std::size_t>(other)]) {
        reach_geoms_.push_back(geoms[i]);
      }
    }
  }
  std::sort(reach_geoms_.begin(), reach_geoms_.end());
  reach_geoms_.erase(std::unique(reach_geoms_.begin(), reach_geoms_.end()), reach_geoms_.end());
  for (const int geom : reach_geoms_) {
    reach_boxes_.push_back(enclose_geom(whole, geom));
    reach_boxes_.back().frame = {};
  }
}

int PhysicsModel::smallest_scene(std::span<const int> count_by_type, bool kinematic_props) const {
  const bool needs_kinematic = kinematic_props && scenes_.back().has_kinematic_props;
  for (int i = kRobotScene; i < full_scene(); ++i) {
    const SceneModel& scene = scenes_[static_cast<std::size_t>(i)];
    if (needs_kinematic && !scene.has_kinematic_props) continue;
    if (scene.has_slots_for(count_by_type)) return i;
  }
  return full_scene();
}

}  // namespace engram
