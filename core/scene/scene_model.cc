#include "core/scene/scene_model.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "core/base/error.h"
#include "core/robot/arm.h"

namespace engram {
namespace {

[[noreturn]] void refuse(const std::string& why) { throw Error(Error::kInternal, why); }

[[noreturn]] void refuse_step(const char* why) {
  throw Error(Error::kInternal, std::string("scene that cannot be stepped: ") + why);
}

// Throws Error unless all pairs' contacts can become constraints: elliptic cones, time constants,
// and integer powers of impedance.
void validate_pairs(const mjModel& model) {
  if (model.opt.cone != mjCONE_ELLIPTIC) refuse_step("its friction cones are not elliptic");
  for (int pair = 0; pair < model.npair; ++pair) {
    const mjtNum* const solref = model.pair_solref + pair * mjNREF;
    if (solref[0] <= 0 || solref[1] <= 0) refuse_step("a contact has no time constant");
    const double exponent = model.pair_solimp[pair * mjNIMP + 4];
    if (exponent != std::round(exponent) || exponent > 10) {
      refuse_step("a contact's impedance has no whole power up to 10");
    }
  }
}

// Throws Error unless contact_step can simulate the model: the robot's joints come first, with one
// coordinate each, and there are no constraints except contacts.
void validate_scene(const mjModel& model) {
  for (int i = 0; i < kRobotJoints; ++i) {
    const int type = model.jnt_type[i];
    if (model.jnt_dofadr[i] != i || (type != mjJNT_HINGE && type != mjJNT_SLIDE)) {
      refuse_step("the robot's nine joints are not its first");
    }
  }
  if (model.neq > 0) refuse_step("there are equality constraints");
  if (model.opt.solver != mjSOL_NEWTON) refuse_step("its solver is not Newton's");
  for (int i = 0; i < model.nv; ++i) {
    if (model.dof_frictionloss[i] != 0) refuse_step("a joint has friction");
  }
  for (int i = 0; i < model.njnt; ++i) {
    if (model.jnt_limited[i] != 0) refuse_step("a joint has a limit that is a constraint");
  }
  validate_pairs(model);
  for (int i = 0; i < model.ntendon; ++i) {
    if (model.tendon_stiffness[i] != 0 || model.tendon_damping[i] != 0 ||
        model.tendon_limited[i] != 0 || model.tendon_frictionloss[i] != 0) {
      refuse_step("a tendon pulls");
    }
  }
}

// Removes from the model what RobotStep simulates: drives, limits, coupling, damping and rotor
// inertia of the robot's joints. Removes gravity.
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

// Bit mask of the robot's joints that move a body; none for a free one.
std::uint16_t moving_joints(const mjModel& model, int body) {
  while (body > 0 && model.body_dofnum[body] == 0) body = model.body_parentid[body];
  int joint = body > 0 ? model.body_dofadr[body] + model.body_dofnum[body] - 1 : -1;
  if (joint >= kRobotJoints) return 0;
  std::uint16_t joints = 0;
  for (; joint >= 0; joint = model.dof_parentid[joint]) {
    joints = static_cast<std::uint16_t>(joints | (1U << static_cast<unsigned>(joint)));
  }
  return joints;
}

PropSlot find_slot(const mjModel& model, int body, int type) {
  const int joint = model.body_jntadr[body];
  if (joint < 0 || model.jnt_type[joint] != mjJNT_FREE) {
    refuse(std::string("prop '") + mj_id2name(&model, mjOBJ_BODY, body) +
           "' has neither a free joint nor a mocap body");
  }
  return {type, body, model.jnt_qposadr[joint], model.jnt_dofadr[joint]};
}

// Appends every choice of `count` more props of the types from `type` on (recursive enumeration).
void append_choices(const std::vector<std::vector<int>>& by_type, std::size_t type,
                    std::size_t count, std::vector<int>& chosen,
                    std::vector<std::vector<int>>& out) {
  if (type == by_type.size()) {
    if (count == 0) out.push_back(chosen);
    return;
  }
  const std::size_t most = std::min(count, by_type[type].size());
  for (std::size_t some = 0; some <= most; ++some) {
    const std::size_t before = chosen.size();
    chosen.insert(chosen.end(), by_type[type].begin(),
                  by_type[type].begin() + static_cast<std::ptrdiff_t>(some));
    append_choices(by_type, type + 1, count - some, chosen, out);
    chosen.resize(before);
  }
}

}  // namespace

bool SceneModel::has_slots_for(std::span<const int> count_by_type) const {
  for (std::size_t type = 0; type < count_by_type.size(); ++type) {
    const auto slots_of_type =
        std::count_if(slots.begin(), slots.end(),
                      [type](const PropSlot& slot) { return slot.type == static_cast<int>(type); });
    if (slots_of_type < count_by_type[type]) return false;
  }
  return true;
}

SceneModel compile_scene(const SceneSpec& source, std::span<const int> props, RobotDetail detail) {
  return make_scene(compile_model(source.compose(props, detail)), source, props);
}

SceneModel make_scene(ModelPtr compiled, const SceneSpec& source, std::span<const int> props) {
  SceneModel scene;
  scene.model = std::move(compiled);
  const mjModel& model = *scene.model;
  if (model.nu != kRobotJoints || model.nv < kRobotJoints) {
    refuse("scene without the nine driven joints of the robot");
  }
  release_robot(*scene.model);
  validate_scene(model);
  scene.kinematics = SceneKinematics(model);
  scene.mocap.assign(source.props.size(), -1);
  for (const int prop : props) {
    const auto index = static_cast<std::size_t>(prop);
    const int body = mj_name2id(&model, mjOBJ_BODY, source.props[index].c_str());
    if (body < 0) refuse("scene without a body named '" + source.props[index] + "'");
    scene.mocap[index] = model.body_mocapid[body];
    if (scene.mocap[index] >= 0) {
      scene.has_kinematic_props = true;
    } else {
      scene.slots.push_back(find_slot(model, body, source.types[index]));
    }
  }
  std::stable_sort(scene.slots.begin(), scene.slots.end(),
                   [](const PropSlot& a, const PropSlot& b) { return a.type < b.type; });
  scene.slot_of_body.assign(static_cast<std::size_t>(model.nbody), -1);
  for (std::size_t i = 0; i < scene.slots.size(); ++i) {
    scene.slot_of_body[static_cast<std::size_t>(scene.slots[i].body)] = static_cast<int>(i);
    scene.free_bodies.emplace_back(model, scene.slots[i].body);
  }
  for (int body = 0; body < model.nbody; ++body) {
    scene.joints_of_body.push_back(moving_joints(model, body));
  }
  return scene;
}

std::vector<std::vector<int>> scene_subsets(const SceneSpec& source,
                                            std::span<const int> free_props, std::size_t limit) {
  std::map<int, std::vector<int>> grouped;
  for (const int prop : free_props) {
    grouped[source.types[static_cast<std::size_t>(prop)]].push_back(prop);
  }
  std::vector<std::vector<int>> by_type;
  by_type.reserve(grouped.size());
  for (auto& [type, members] : grouped) by_type.push_back(std::move(members));

  std::vector<std::vector<int>> subsets;
  // Large scenes cost nearly the same, so their sizes may be further apart.
  for (std::size_t count = 1; count < free_props.size(); count += 1 + count / 4) {
    std::vector<std::vector<int>> more;
    std::vector<int> chosen;
    append_choices(by_type, 0, count, chosen, more);
    if (subsets.size() + more.size() > limit) break;
    for (std::vector<int>& subset : more) {
      std::sort(subset.begin(), subset.end());
      subsets.push_back(std::move(subset));
    }
  }
  return subsets;
}

}  // namespace engram
