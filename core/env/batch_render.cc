// Pictures of a batch.
#include "core/base/error.h"
#include "core/base/ieee_scope.h"
#include "core/env/batch.h"

namespace engram {
namespace {

constexpr std::string_view kRenderCamera = "render_camera";

}  // namespace

using Bytes = std::span<const std::uint8_t>;
using Cells = std::span<const std::int16_t>;

Bytes Batch::rgb() const { return images_ ? images_->rgb().now.span() : Bytes(); }
Cells Batch::depth() const { return images_ ? images_->depth().now.span() : Cells(); }
Cells Batch::segmentation() const { return images_ ? images_->segmentation().now.span() : Cells(); }

Bytes Batch::final_rgb() const { return images_ ? images_->rgb().finals.span() : Bytes(); }
Cells Batch::final_depth() const { return images_ ? images_->depth().finals.span() : Cells(); }
Cells Batch::final_segmentation() const {
  return images_ ? images_->segmentation().finals.span() : Cells();
}

std::span<const std::string> Batch::segmentation_names() const {
  return segmentation().empty() ? std::span<const std::string>() : images_->segments();
}

void Batch::overlay(int env, Overlay& out) const {
  const IeeeScope scope;
  check_env(env);
  task_->overlay(env, out);
}

void Batch::render(int env, std::string_view camera, int width, int height,
                   std::span<std::uint8_t> rgb) {
  const IeeeScope scope;
  check_env(env);
  check_image_size(width, height);
  require_length("image", rgb.size(),
                 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  if (!started_) throw Error(Error::kBadState, "render before the first reset; reset first");
  if (!views_) views_ = std::make_unique<SceneViews>(*model_, 1);
  const bool for_people = camera == kRenderCamera;
  std::unique_ptr<ImageSource>& source = for_people ? render_source_ : sensor_source_;
  if (!source) {
    if (!renderers_) throw Error(Error::kUnavailable, "pictures without a renderer");
    ImageSourceOptions options = for_people ? options_.render_options : options_.image_options;
    options.max_size = kMaxImageSize;
    options.for_people = for_people;
    source =
        std::make_unique<ImageSource>(document(), views_->body_names(), options, 1, renderers_);
  }
  RenderImage image;
  image.camera = find_camera(*source, camera);
  image.width = width;
  image.height = height;
  image.rgb = rgb.data();
  image.row_stride = 3 * static_cast<std::ptrdiff_t>(width);
  source->render(0, views_->view(0, state_, env), {&image, 1});
}

}  // namespace engram
