#include "core/image/image_batch.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/index.h"
#include "core/base/join.h"
#include "core/math/display_color.h"

namespace engram {

void check_image_size(int width, int height) {
  if (std::min(width, height) >= 1 && std::max(width, height) <= kMaxImageSize) return;
  throw Error(Error::kInvalidArgument, "image size: " + std::to_string(width) + " x " +
                                           std::to_string(height) +
                                           " given, 1 to 4096 pixels on each side allowed");
}

int find_camera(const ImageSource& source, std::string_view name) {
  const std::vector<std::string>& cameras = source.cameras();
  const auto found = std::find(cameras.begin(), cameras.end(), name);
  if (found != cameras.end()) return static_cast<int>(found - cameras.begin());
  throw Error(Error::kUnknownId,
              "no camera '" + std::string(name) + "'; this scene has: " + join(cameras));
}

void add_faults(SensorFaults& faults, std::span<const RenderImage> images,
                const ImageChanges& changes, std::uint64_t key) {
  constexpr std::uint64_t kNextCamera = 0x9e3779b97f4a7c15u;
  for (const RenderImage& image : images) {
    faults.blur(image, changes.blur);
    faults.add_noise(image, changes.noise,
                     key + static_cast<std::uint64_t>(image.camera) * kNextCamera);
  }
}

SceneViews::SceneViews(const PhysicsModel& model, int workers) : model_(model) {
  for (int body = 1; body < model.robot().nbody; ++body) {
    robot_bodies_.push_back(attachment_of(model.robot(), body));
  }
  const std::vector<BodyView> one(robot_bodies_.size() + model.props().size());
  views_.assign(at(workers), one);
}

std::vector<std::string> SceneViews::body_names() const {
  std::vector<std::string> names;
  for (int body = 1; body < model_.robot().nbody; ++body) {
    names.emplace_back(mj_id2name(&model_.robot(), mjOBJ_BODY, body));
  }
  for (const PropModel& prop : model_.props()) names.push_back(prop.name);
  return names;
}

std::span<const BodyView> SceneViews::view(int worker, const State& state, int env) {
  std::vector<BodyView>& views = views_[at(worker)];
  const std::size_t robot = robot_bodies_.size();
  const RobotPose pose = pose_at(model_.robot_model(), state.qpos.row(env));
  for (std::size_t i = 0; i < robot; ++i) views[i].frame = carried(pose, robot_bodies_[i]);
  for (int prop = 0; prop < state.num_props; ++prop) {
    BodyView& view = views[robot + at(prop)];
    view.visible = state.status_of(env, prop) != PropStatus::kHidden;
    if (view.visible) {
      view.frame = make_frame(state.prop_pos_of(env, prop), state.prop_quat_of(env, prop));
    }
    const float* painted = state.prop_rgba.row(env) + 4 * prop;
    view.rgba[3] = painted[3];
    for (int k = 0; k < 3 && painted[3] > 0; ++k) {
      view.rgba[k] = static_cast<float>(display_level(painted[k]));
    }
    view.emission = state.prop_emission.row(env)[prop];
  }
  return views;
}

ImageBatch::ImageBatch(const PhysicsModel& model, const std::string& document,
                       const ImageShape& shape, ImageKinds kinds,
                       const RendererFactory& make_renderer, const ImageSourceOptions& options,
                       int num_envs, int workers, bool keeps_finals)
    : views_(model, workers) {
  check_image_size(shape.width, shape.height);
  if (shape.cameras.empty()) {
    throw Error(Error::kInvalidArgument, "image observations: no camera given, 1 or more needed");
  }
  ImageSourceOptions fitted = options;
  fitted.for_people = false;
  fitted.max_size = std::max(shape.width, shape.height);
  source_ =
      std::make_unique<ImageSource>(document, views_.body_names(), fitted, workers, make_renderer);
  RenderImage request;
  request.width = shape.width;
  request.height = shape.height;
  request.pixel_stride = 3 * static_cast<std::ptrdiff_t>(shape.cameras.size());
  request.row_stride = request.pixel_stride * shape.width;
  request.cell_step = static_cast<std::ptrdiff_t>(shape.cameras.size());
  request.cell_row = request.cell_step * shape.width;
  std::vector<RenderImage> one;
  for (const std::string& name : shape.cameras) {
    request.camera = find_camera(*source_, name);
    one.push_back(request);
  }
  requests_.assign(at(workers), one);
  faults_.resize(at(workers));
  for (SensorFaults& faults : faults_) {
    if (options.has_faults) faults.reserve(shape.width, shape.height);
  }
  const std::size_t cells = shape.cells();
  rgb_ = ImageBuffer<std::uint8_t>(3 * cells, num_envs, keeps_finals);
  if (kinds.depth) depth_ = ImageBuffer<std::int16_t>(cells, num_envs, keeps_finals);
  if (kinds.segmentation) segmentation_ = ImageBuffer<std::int16_t>(cells, num_envs, keeps_finals);
}

void ImageBatch::render(int worker, const State& state, int env, const ImageChanges* changes,
                        std::uint64_t noise_key) {
  std::vector<RenderImage>& requests = requests_[at(worker)];
  for (std::size_t camera = 0; camera < requests.size(); ++camera) {
    RenderImage& request = requests[camera];
    request.rgb = rgb_.of(env) + 3 * camera;
    if (depth_.size() > 0) request.depth_mm = depth_.of(env) + camera;
    if (segmentation_.size() > 0) request.segment_id = segmentation_.of(env) + camera;
  }
  source_->render(worker, views_.view(worker, state, env), requests, changes);
  if (changes == nullptr) return;
  add_faults(faults_[at(worker)], requests, *changes, noise_key);
}

void ImageBatch::keep_final(int env) {
  rgb_.keep_final(env);
  depth_.keep_final(env);
  segmentation_.keep_final(env);
}

void ImageBatch::repeat(int env) {
  rgb_.repeat(env);
  depth_.repeat(env);
  segmentation_.repeat(env);
}

void ImageBatch::draw_into(const ImageTargets& now, const ImageTargets& finals) {
  rgb_.draw_into(now.rgb, finals.rgb);
  depth_.draw_into(now.depth, finals.depth);
  segmentation_.draw_into(now.segmentation, finals.segmentation);
}

void ImageBatch::swap_to(const ImageTargets& now) {
  rgb_.swap_to(now.rgb);
  depth_.swap_to(now.depth);
  segmentation_.swap_to(now.segmentation);
}

}  // namespace engram
