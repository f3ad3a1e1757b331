// Poses of a scene's cameras, as matrices, without a renderer.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/image/image_changes.h"
#include "core/robot/robot_pose.h"
#include "core/scene/physics_model.h"

namespace engram {

// Destinations of the matrices of a batch, row by row; empty spans are left out.
struct CameraSpans {
  std::span<float> extrinsic_cv;  // (N, 3, 4) world to camera: x right, y down, z forward
  std::span<float> cam2world_gl;  // (N, 4, 4) camera to world: x right, y up, z backward
  std::span<float> intrinsic_cv;  // (N, 3, 3) pixels; pixel (0, 0) covers 0 to 1
};

class CameraPoses {
 public:
  // document: MJCF of the scene that the model, which must outlive this object, simulates.
  CameraPoses(const std::string& document, const PhysicsModel& model);

  // Index of a camera. Throws Error naming those that exist.
  int find(std::string_view name) const;
  // Transform from the camera's frame (x right, y up, z backward) to the world, with the changes of
  // an environment.
  Eigen::Isometry3d pose(int camera, const double* qpos, const ImageChanges& changes = {}) const;
  // Pixels from the centre of an image of that height, at unit distance and offset.
  double focal_length(int camera, int height, const ImageChanges& changes = {}) const;

 private:
  struct Camera {
    std::string name;
    Attachment attachment;
    double fovy = 0;  // rad
  };
  // What changes a camera, or null.
  const CameraChange* change_of(int camera, const ImageChanges& changes) const;

  const RobotModel& robot_;
  std::vector<Camera> cameras_;
};

}  // namespace engram
