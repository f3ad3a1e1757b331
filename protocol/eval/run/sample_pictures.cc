#include "protocol/eval/run/sample_pictures.h"

#include <algorithm>

#include "media/png.h"

namespace engram {

// Takes a picture every so many steps; whenever there are too many, every second one is dropped and
// the distance doubled.
void SamplePictures::sample(const Batch& env, int index) {
  constexpr std::size_t kMost = 16;
  const int step = env.state().elapsed[index];
  const bool ended = (env.terminated()[static_cast<std::size_t>(index)] |
                      env.truncated()[static_cast<std::size_t>(index)]) != 0;
  if (step % stride_ != 0 && !ended) return;
  capture(env, index);
  if (pictures_.size() < kMost || ended) return;
  stride_ *= 2;
  std::erase_if(pictures_, [this](const Picture& picture) { return picture.step % stride_ != 0; });
}

void SamplePictures::capture(const Batch& env, int index) {
  Picture picture{env.state().elapsed[index],
                  std::vector<std::uint8_t>(std::size_t{kSide} * kSide * 3)};
  const ImageShape& shape = env.options().images;
  if (env.options().obs_mode == ObsMode::kRgb && shape.width == kSide && shape.height == kSide) {
    const std::uint8_t* pixel =
        env.images().rgb.data() + static_cast<std::size_t>(index) * 3 * shape.cells();
    const std::size_t stride = 3 * shape.cameras.size();
    for (std::size_t i = 0; i < picture.rgb.size(); i += 3, pixel += stride) {
      std::copy_n(pixel, 3, picture.rgb.begin() + static_cast<std::ptrdiff_t>(i));
    }
  } else {
    if (!renderer_) renderer_.emplace(env);
    renderer_->render(index, ImageShape().cameras.front(), kSide, kSide, picture.rgb);
  }
  pictures_.push_back(std::move(picture));
}

Bytes SamplePictures::png() const {
  const std::size_t count = std::min<std::size_t>(kPictures, pictures_.size());
  if (count == 0) return {};
  const std::size_t row = std::size_t{kSide} * 3;
  std::vector<std::uint8_t> strip(count * row * kSide);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t chosen = count == 1 ? 0 : i * (pictures_.size() - 1) / (count - 1);
    const std::vector<std::uint8_t>& rgb = pictures_[chosen].rgb;
    for (std::size_t y = 0; y < kSide; ++y) {
      std::copy_n(rgb.begin() + static_cast<std::ptrdiff_t>(y * row), row,
                  strip.begin() + static_cast<std::ptrdiff_t>((y * count + i) * row));
    }
  }
  return png_bytes(static_cast<int>(count) * kSide, kSide, strip);
}

}  // namespace engram
