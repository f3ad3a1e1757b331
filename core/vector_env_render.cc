// Pictures of a batch.
#include "core/error.h"
#include "core/length.h"
#include "core/vector_env.h"

namespace engram {

std::span<const std::uint8_t> VectorEnv::rgb() const {
  return images_ ? images_->images() : std::span<const std::uint8_t>{};
}

std::span<const std::uint8_t> VectorEnv::final_rgb() const {
  return images_ ? images_->finals() : std::span<const std::uint8_t>{};
}

void VectorEnv::render(int env, std::string_view camera, int width, int height,
                       std::span<std::uint8_t> rgb) {
  check_env(env);
  check_image_size(width, height);
  require_length("image", rgb.size(),
                 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  if (!started_) throw Error(Error::kBadState, "render before the first reset; reset first");
  if (!source_) {
    if (!renderers_) throw Error(Error::kUnavailable, "pictures without a renderer");
    views_ = std::make_unique<SceneViews>(*model_, 1);
    ImageSourceOptions options = options_.image_options;
    options.max_size = 4096;
    source_ = renderers_(document(), views_->body_names(), options, 1);
  }
  RenderImage image;
  image.camera = find_camera(*source_, camera);
  image.width = width;
  image.height = height;
  image.rgb = rgb.data();
  image.row_stride = 3 * static_cast<std::ptrdiff_t>(width);
  source_->render(0, views_->view(0, state_, env), {&image, 1});
}

}  // namespace engram
