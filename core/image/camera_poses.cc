#include "core/image/camera_poses.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/base/join.h"
#include "core/math/real_functions.h"
#include "core/scene/mujoco_handle.h"

namespace engram {
namespace {

template <class Number>
Eigen::Isometry3d isometry(const Number* pos, const Number* quat) {
  Eigen::Isometry3d pose;
  pose.linear() = Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]).toRotationMatrix();
  pose.translation() << pos[0], pos[1], pos[2];
  pose.makeAffine();
  return pose;
}

}  // namespace

CameraPoses::CameraPoses(const std::string& document, const mjModel& robot) : robot_(robot) {
  bodies_.resize(robot_.names().size());
  const ModelPtr model = compile_model(document);
  for (int i = 0; i < model->ncam; ++i) {
    Camera camera;
    camera.name = mj_id2name(model.get(), mjOBJ_CAMERA, i);
    camera.local = isometry(model->cam_pos + 3 * i, model->cam_quat + 4 * i);
    camera.fovy = model->cam_fovy[i] * std::numbers::pi / 180;
    if (model->cam_bodyid[i] > 0) {
      const std::string body = mj_id2name(model.get(), mjOBJ_BODY, model->cam_bodyid[i]);
      const auto found = std::ranges::find(robot_.names(), body);
      if (found == robot_.names().end()) {
        throw Error(Error::kInternal, "camera '" + camera.name + "' is on no body of the robot");
      }
      camera.body = static_cast<int>(found - robot_.names().begin());
    }
    cameras_.push_back(camera);
  }
}

int CameraPoses::find(std::string_view name) const {
  const auto found = std::ranges::find(cameras_, name, &Camera::name);
  if (found != cameras_.end()) return static_cast<int>(found - cameras_.begin());
  throw Error(Error::kUnknownId, "no camera '" + std::string(name) +
                                     "'; this scene has: " + join(cameras_, &Camera::name));
}

Eigen::Isometry3d CameraPoses::pose(int camera, const double* qpos) {
  const Camera& known = cameras_[static_cast<std::size_t>(camera)];
  if (known.body < 0) return known.local;
  robot_.compute(qpos, bodies_);
  const BodyView& body = bodies_[static_cast<std::size_t>(known.body)];
  return isometry(body.pos, body.quat) * known.local;
}

double CameraPoses::focal_length(int camera, int height) const {
  return height / 2.0 / real::tan(cameras_[static_cast<std::size_t>(camera)].fovy / 2);
}

}  // namespace engram
