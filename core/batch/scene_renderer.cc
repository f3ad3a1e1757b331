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
  batch_.check_env(env);
  check_image_size(width, height);
  require_length("image", rgb.size(),
                 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  batch_.require_started("render");
  ImageSource& source = source_for(camera == kRenderCamera);
  RenderImage image;
  image.camera = find_camera(source, camera);
  image.width = width;
  image.height = height;
  image.rgb = rgb.data();
  image.row_stride = 3 * static_cast<std::ptrdiff_t>(width);
  const Perturbations& perturbations = batch_.perturbations_;
  const ImageChanges changes = perturbations.images(env);
  source.render(0, views_->view(0, batch_.state(), env), {&image, 1}, &changes);
  if (camera != kRenderCamera) {
    add_faults(faults_, {&image, 1}, changes, batch_.image_noise_key(env));
  }
}

ImageSource& SceneRenderer::source_for(bool people) {
  if (!views_) views_ = std::make_unique<SceneViews>(batch_.physics_model(), 1);
  std::unique_ptr<ImageSource>& source = people ? render_source_ : sensor_source_;
  if (source) return *source;
  if (!batch_.renderers_) throw Error(Error::kUnavailable, "images without a renderer");
  const BatchOptions& given = batch_.options();
  ImageSourceOptions options = people ? given.render_options : given.image_options;
  options.max_size = kMaxImageSize;
  options.for_people = people;
  options.varies = batch_.perturbations_.change_scene();
  source = std::make_unique<ImageSource>(batch_.task_->document(), views_->body_names(), options, 1,
                                         batch_.renderers_);
  return *source;
}

void SceneRenderer::overlay(int env, Overlay& out) const {
  const IeeeScope scope;
  batch_.check_env(env);
  batch_.task_->overlay(env, out);
}

}  // namespace engram
