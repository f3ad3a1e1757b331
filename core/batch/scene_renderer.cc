#include "core/batch/scene_renderer.h"

#include "core/base/error.h"
#include "core/base/ieee_scope.h"

namespace engram {
namespace {

constexpr std::string_view kRenderCamera = "render_camera";

}  // namespace

void SceneRenderer::render(int env, std::string_view camera, int width, int height,
                           std::span<std::uint8_t> rgb) {
  const IeeeScope scope;
  const auto [part, own_env] = batch_.locate(env);
  const BatchData& data = BatchAccess::data(batch_.part(part));
  check_image_size(width, height);
  require_length("image", rgb.size(), 3 * at(width) * at(height));
  data.require_started("render");
  Views& views = views_[at(part)];
  ImageSource& source = source_for(data, views, camera == kRenderCamera);
  RenderImage image;
  image.camera = find_camera(source, camera);
  image.width = width;
  image.height = height;
  image.rgb = rgb.data();
  image.row_stride = 3 * static_cast<std::ptrdiff_t>(width);
  const ImageChanges changes = data.perturbations.images(own_env);
  source.render(0, views.bodies->view(0, data.state, own_env), {&image, 1}, &changes);
  if (camera != kRenderCamera) {
    add_faults(faults_, {&image, 1}, changes, data.image_noise_key(own_env));
  }
}

ImageSource& SceneRenderer::source_for(const BatchData& data, Views& views, bool people) {
  if (!views.bodies) views.bodies = std::make_unique<SceneViews>(*data.model, 1);
  std::unique_ptr<ImageSource>& source = people ? views.render_source : views.sensor_source;
  if (source) return *source;
  if (!data.renderers) throw Error(Error::kUnavailable, "images without a renderer");
  ImageSourceOptions options = people ? data.options.render_options : data.options.image_options;
  options.max_size = kMaxImageSize;
  options.for_people = people;
  options.varies = data.perturbations.change_scene();
  source = std::make_unique<ImageSource>(data.task->document(), views.bodies->body_names(), options,
                                         1, data.renderers);
  return *source;
}

void SceneRenderer::overlay(int env, Overlay& out) const {
  const IeeeScope scope;
  const auto [part, own_env] = batch_.locate(env);
  BatchAccess::data(batch_.part(part)).task->overlay(own_env, out);
}

}  // namespace engram
