// The image observations of a batch, and images of single environments for people.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/image/image_buffer.h"
#include "core/image/image_options.h"
#include "core/image/image_source.h"
#include "core/image/sensor_faults.h"
#include "core/robot/robot_pose.h"
#include "core/scene/physics_model.h"
#include "core/sim/state.h"

namespace engram {

// The bodies of an environment as an ImageSource needs them: the robot's, then the props.
class SceneViews {
 public:
  SceneViews(const PhysicsModel& model, int workers);

  std::vector<std::string> body_names() const;
  // Poses and appearance of all bodies in one environment; valid until the worker's next call.
  std::span<const BodyView> view(int worker, const State& state, int env);

 private:
  const PhysicsModel& model_;
  std::vector<Attachment> robot_bodies_;
  std::vector<std::vector<BodyView>> views_;  // one per worker
};

// Images of observations, besides colours.
struct ImageKinds {
  bool depth = false;
  bool segmentation = false;
};

// Arrays for images; null where there is none.
struct ImageTargets {
  std::uint8_t* rgb = nullptr;
  std::int16_t* depth = nullptr;
  std::int16_t* segmentation = nullptr;
};

class ImageBatch {
 public:
  // Throws Error for sizes out of range, unknown cameras or a renderer that cannot work here.
  ImageBatch(const PhysicsModel& model, const std::string& document, const ImageShape& shape,
             ImageKinds kinds, const RendererFactory& make_renderer,
             const ImageSourceOptions& options, int num_envs, int workers, bool keeps_finals);

  // (num_envs, height, width, 3 * cameras)
  const ImageBuffer<std::uint8_t>& rgb() const { return rgb_; }
  // (num_envs, height, width, cameras); empty unless asked for.
  const ImageBuffer<std::int16_t>& depth() const { return depth_; }
  const ImageBuffer<std::int16_t>& segmentation() const { return segmentation_; }
  // Index -> name.
  const std::vector<std::string>& segments() const { return source_->segments(); }
  // Size of one environment's images, without finals.
  std::size_t bytes() const {
    return rgb_.size() + sizeof(std::int16_t) * (depth_.size() + segmentation_.size());
  }

  // See Images::draw_into and swap_to.
  void draw_into(const ImageTargets& now, const ImageTargets& finals);
  void swap_to(const ImageTargets& now);

  // Draws one environment as it is now. changes: where options.varies says that there are some;
  // noise_key: of this environment's sensors in this step.
  void render(int worker, const State& state, int env, const ImageChanges* changes = nullptr,
              std::uint64_t noise_key = 0);
  // Keeps the present image as the one at the episode's end.
  void keep_final(int env);
  // Leaves one environment as it was in the step before.
  void repeat(int env);

 private:
  SceneViews views_;
  std::unique_ptr<ImageSource> source_;
  std::vector<std::vector<RenderImage>> requests_;  // one per worker
  std::vector<SensorFaults> faults_;                // one per worker
  ImageBuffer<std::uint8_t> rgb_;
  ImageBuffer<std::int16_t> depth_;
  ImageBuffer<std::int16_t> segmentation_;
};

// Blurs the colours of images, then adds noise; key: of these images.
void add_faults(SensorFaults& faults, std::span<const RenderImage> images,
                const ImageChanges& changes, std::uint64_t key);

// Index of a camera. Throws Error naming those that exist.
int find_camera(const ImageSource& source, std::string_view name);

inline constexpr int kMaxImageSize = 4096;  // pixels of either side

// Throws Error unless both sides are 1 to kMaxImageSize pixels.
void check_image_size(int width, int height);

}  // namespace engram
