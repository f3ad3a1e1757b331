#include "core/batch/resting_scene.h"

#include <algorithm>
#include <vector>

#include "core/scene/mujoco_handle.h"

namespace engram {
namespace {

constexpr int kSteps = 500;             // five seconds
constexpr int kRounds = 5;              // a prop that is put down may move its neighbours
constexpr double kDisplacement = 5e-4;  // m: a prop that never moves more stands already

// Free props of the scene that are present, with their largest displacement.
struct Standing {
  std::size_t prop = 0;
  int body = 0;
  double displacement = 0;  // m
};

std::vector<Standing> standing_props(const mjModel& model, const PhysicsModel& physics,
                                     const DrawnScene& drawn) {
  std::vector<Standing> result;
  for (std::size_t i = 0; i < drawn.props.size(); ++i) {
    const PropModel& prop = physics.props()[i];
    if (drawn.props[i].hidden || !prop.free) continue;
    result.push_back({i, mj_name2id(&model, mjOBJ_BODY, prop.name.c_str())});
  }
  return result;
}

// Steps the scene and puts props that move where they come to rest. False: nothing moves.
bool let_rest(const Task& task, const PhysicsModel& physics, DrawnScene& drawn) {
  const ModelPtr model = compile_model(task.drawn_document(drawn));
  const DataPtr data = make_data(*model);
  std::vector<Standing> props = standing_props(*model, physics, drawn);
  mj_resetDataKeyframe(model.get(), data.get(), 0);
  for (int i = 0; i < kSteps; ++i) {
    mj_step(model.get(), data.get());
    for (Standing& one : props) {
      const double moved = mju_dist3(data->xpos + 3 * one.body, drawn.props[one.prop].pos.data());
      one.displacement = std::max(one.displacement, moved);
    }
  }
  mj_kinematics(model.get(), data.get());
  std::erase_if(props, [](const Standing& one) { return one.displacement < kDisplacement; });
  for (const Standing& one : props) {
    std::copy_n(data->xpos + 3 * one.body, 3, drawn.props[one.prop].pos.begin());
    std::copy_n(data->xquat + 4 * one.body, 4, drawn.props[one.prop].quat.begin());
  }
  return !props.empty();
}

}  // namespace

DrawnScene resting_scene(const Task& task, const PhysicsModel& physics, const DrawnScene& drawn) {
  const MujocoScope scope;
  DrawnScene resting = drawn;
  for (int round = 0; round < kRounds; ++round) {
    if (!let_rest(task, physics, resting)) break;
  }
  return resting;
}

}  // namespace engram
