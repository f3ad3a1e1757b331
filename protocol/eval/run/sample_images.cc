#include "protocol/eval/run/sample_images.h"

#include <algorithm>

#include "media/png.h"

namespace engram {

// Takes an image every `stride_` steps; whenever there are too many, every second one is dropped
// and the distance doubled.
void SampleImages::sample(const Batch& batch, int index) {
  constexpr std::size_t kMax = 16;
  const int step = batch.state().elapsed[index];
  const bool ended = (batch.outputs().terminated[static_cast<std::size_t>(index)] |
                      batch.outputs().truncated[static_cast<std::size_t>(index)]) != 0;
  if (step % stride_ != 0 && !ended) return;
  capture(batch, index);
  if (images_.size() < kMax || ended) return;
  stride_ *= 2;
  std::erase_if(images_, [this](const Image& image) { return image.step % stride_ != 0; });
}

void SampleImages::capture(const Batch& batch, int index) {
  Image image{batch.state().elapsed[index],
              std::vector<std::uint8_t>(std::size_t{kSide} * kSide * 3)};
  const ImageShape& shape = batch.options().images;
  if (batch.options().obs_mode == ObsMode::kRgb && shape.width == kSide && shape.height == kSide) {
    const std::uint8_t* pixel =
        batch.images().rgb.data() + static_cast<std::size_t>(index) * 3 * shape.cells();
    const std::size_t stride = 3 * shape.cameras.size();
    for (std::size_t i = 0; i < image.rgb.size(); i += 3, pixel += stride) {
      std::copy_n(pixel, 3, image.rgb.begin() + static_cast<std::ptrdiff_t>(i));
    }
  } else {
    if (!renderer_) renderer_.emplace(batch);
    renderer_->render(index, ImageShape().cameras.front(), kSide, kSide, image.rgb);
  }
  images_.push_back(std::move(image));
}

Bytes SampleImages::png() const {
  const std::size_t count = std::min<std::size_t>(kImages, images_.size());
  if (count == 0) return {};
  const std::size_t row = std::size_t{kSide} * 3;
  std::vector<std::uint8_t> strip(count * row * kSide);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t chosen = count == 1 ? 0 : i * (images_.size() - 1) / (count - 1);
    const std::vector<std::uint8_t>& rgb = images_[chosen].rgb;
    for (std::size_t y = 0; y < kSide; ++y) {
      std::copy_n(rgb.begin() + static_cast<std::ptrdiff_t>(y * row), row,
                  strip.begin() + static_cast<std::ptrdiff_t>((y * count + i) * row));
    }
  }
  return png_bytes(static_cast<int>(count) * kSide, kSide, strip);
}

}  // namespace engram
