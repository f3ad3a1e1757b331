#include "core/image/camera_poses.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/base/index.h"
#include "core/base/join.h"
#include "core/math/real_functions.h"
#include "core/scene/mujoco_handle.h"

namespace engram {

CameraPoses::CameraPoses(const std::string& document, const PhysicsModel& physics)
    : robot_(physics.robot_model()) {
  const mjModel& robot = physics.robot();
  const ModelPtr model = compile_model(document);
  for (int i = 0; i < model->ncam; ++i) {
    Camera camera;
    camera.name = mj_id2name(model.get(), mjOBJ_CAMERA, i);
    camera.fovy = model->cam_fovy[i] * std::numbers::pi / 180;
    const Frame local = make_frame(model->cam_pos + 3 * i, model->cam_quat + 4 * i);
    camera.attachment.frame = local;
    if (model->cam_bodyid[i] > 0) {
      const int body =
          mj_name2id(&robot, mjOBJ_BODY, mj_id2name(model.get(), mjOBJ_BODY, model->cam_bodyid[i]));
      if (body < 0) {
        throw Error(Error::kInternal, "camera '" + camera.name + "' is on no body of the robot");
      }
      camera.attachment = attachment_of(robot, body);
      Frame& frame = camera.attachment.frame;
      frame = {frame.pos + frame.axes * local.pos, frame.axes * local.axes};
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

const CameraChange* CameraPoses::change_of(int camera, const ImageChanges& changes) const {
  if (!changes.cameras) return nullptr;
  const auto found = std::ranges::find(kSensorCameraNames, cameras_[at(camera)].name);
  if (found == kSensorCameraNames.end()) return nullptr;
  return &changes.camera[static_cast<std::size_t>(found - kSensorCameraNames.begin())];
}

Eigen::Isometry3d CameraPoses::pose(int camera, const double* qpos,
                                    const ImageChanges& changes) const {
  const Attachment& attachment = cameras_[at(camera)].attachment;
  Frame frame = carried(pose_at(robot_, qpos), attachment);
  if (const CameraChange* change = change_of(camera, changes)) frame = moved(frame, *change);
  Eigen::Isometry3d pose;
  pose.linear() = frame.axes;
  pose.translation() = frame.pos;
  pose.makeAffine();
  return pose;
}

double CameraPoses::focal_length(int camera, int height, const ImageChanges& changes) const {
  double fovy = cameras_[at(camera)].fovy;
  if (const CameraChange* change = change_of(camera, changes)) fovy += change->fovy;
  return height / 2.0 / real::tan(fovy / 2);
}

}  // namespace engram
