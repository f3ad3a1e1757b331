// The image observations of a batch, and pictures of single environments for people.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/aligned_array.h"
#include "core/physics/model.h"
#include "core/physics/state.h"
#include "core/picture/image_source.h"
#include "core/picture/robot_poses.h"

namespace engram {

// The bodies of an environment as an ImageSource needs them: the robot's, then the props.
class SceneViews {
 public:
  SceneViews(const PhysicsModel& model, int workers);

  std::vector<std::string> body_names() const;
  // Where everything is in one environment; valid until the worker's next call.
  std::span<const BodyView> view(int worker, const State& state, int env);

 private:
  const PhysicsModel& model_;
  RobotPoses robot_;
  std::vector<std::vector<BodyView>> views_;  // one per worker
};

class ImageBatch {
 public:
  // Throws Error for sizes out of range, unknown cameras or a renderer that cannot work here.
  ImageBatch(const PhysicsModel& model, const std::string& document, const ImageShape& shape,
             const ImageSourceFactory& factory, const ImageSourceOptions& options, int num_envs,
             int workers, bool keeps_finals);

  // (num_envs, height, width, 3 * cameras), and the same at the end of the last episodes.
  std::span<const std::uint8_t> images() const { return images_.span(); }
  std::span<const std::uint8_t> finals() const { return finals_.span(); }

  // Draws one environment as it is now.
  void render(int worker, const State& state, int env);
  // Keeps the present image as the one at the episode's end.
  void keep_final(int env);

 private:
  ImageShape shape_;
  SceneViews views_;
  std::unique_ptr<ImageSource> source_;
  std::vector<int> cameras_;
  std::vector<std::vector<RenderImage>> requests_;  // one per worker
  AlignedArray<std::uint8_t> images_;
  AlignedArray<std::uint8_t> finals_;
};

// Index of a camera. Throws Error naming those that exist.
int find_camera(const ImageSource& source, std::string_view name);

inline constexpr int kMaxImageSize = 4096;  // pixels of either side

// Throws Error unless both sides are 1 to kMaxImageSize pixels.
void check_image_size(int width, int height);

}  // namespace engram
