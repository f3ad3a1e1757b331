#include "core/picture/image_batch.h"

#include <algorithm>

#include "core/base/display_color.h"
#include "core/base/error.h"
#include "core/base/join.h"

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

SceneViews::SceneViews(const PhysicsModel& model, int workers)
    : model_(model), robot_(model.robot()) {
  const std::vector<BodyView> one(robot_.names().size() + model.props().size());
  views_.assign(static_cast<std::size_t>(workers), one);
}

std::vector<std::string> SceneViews::body_names() const {
  std::vector<std::string> names = robot_.names();
  for (const PropModel& prop : model_.props()) names.push_back(prop.name);
  return names;
}

std::span<const BodyView> SceneViews::view(int worker, const State& state, int env) {
  std::vector<BodyView>& views = views_[static_cast<std::size_t>(worker)];
  const std::size_t robot = robot_.names().size();
  robot_.compute(state.qpos.row(env), std::span(views).first(robot));
  for (int prop = 0; prop < state.num_props; ++prop) {
    BodyView& view = views[robot + static_cast<std::size_t>(prop)];
    view.visible = state.status_of(env, prop) != PropStatus::kHidden;
    std::copy_n(state.prop_pos_of(env, prop), 3, view.pos);
    std::copy_n(state.prop_quat_of(env, prop), 4, view.quat);
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
                       const ImageShape& shape, const ImageSourceFactory& factory,
                       const ImageSourceOptions& options, int num_envs, int workers,
                       bool keeps_finals)
    : shape_(shape), views_(model, workers) {
  check_image_size(shape.width, shape.height);
  if (shape.cameras.empty()) {
    throw Error(Error::kInvalidArgument, "image observations: no camera given, 1 or more needed");
  }
  ImageSourceOptions fitted = options;
  fitted.for_people = false;
  fitted.max_size = std::max(shape.width, shape.height);
  source_ = factory(document, views_.body_names(), fitted, workers);
  RenderImage request;
  request.width = shape.width;
  request.height = shape.height;
  request.pixel_stride = 3 * static_cast<std::ptrdiff_t>(shape.cameras.size());
  request.row_stride = request.pixel_stride * shape.width;
  std::vector<RenderImage> one;
  for (const std::string& name : shape.cameras) {
    request.camera = find_camera(*source_, name);
    one.push_back(request);
  }
  requests_.assign(static_cast<std::size_t>(workers), one);
  const std::size_t bytes = shape.bytes() * static_cast<std::size_t>(num_envs);
  images_ = AlignedArray<std::uint8_t>(bytes);
  if (keeps_finals) finals_ = AlignedArray<std::uint8_t>(bytes);
}

void ImageBatch::render(int worker, const State& state, int env) {
  std::vector<RenderImage>& requests = requests_[static_cast<std::size_t>(worker)];
  std::uint8_t* first = images_.data() + shape_.bytes() * static_cast<std::size_t>(env);
  for (std::size_t camera = 0; camera < requests.size(); ++camera) {
    requests[camera].rgb = first + 3 * camera;
  }
  source_->render(worker, views_.view(worker, state, env), requests);
}

void ImageBatch::keep_final(int env) {
  const std::size_t bytes = shape_.bytes();
  const std::size_t offset = bytes * static_cast<std::size_t>(env);
  std::copy_n(images_.data() + offset, bytes, finals_.data() + offset);
}

}  // namespace engram
