#include "core/image/sensor_faults.h"

#include <algorithm>
#include <cmath>

#include "core/base/index.h"
#include "core/image/image_changes.h"
#include "core/math/real_functions.h"

namespace engram {
namespace {

constexpr int kChannels = 3;
constexpr double kReferenceHeight = 128;
constexpr double kKernelReach = 3;  // standard deviations to either side
constexpr std::uint32_t kOne = 1 << 16;

int reach_of(double sigma) { return static_cast<int>(std::ceil(kKernelReach * sigma)); }

std::uint8_t* pixel(const RenderImage& image, int x, int y) {
  return image.rgb + y * image.row_stride + x * image.pixel_stride;
}

// 32 well mixed bits of a number.
std::uint32_t mixed(std::uint32_t bits) {
  bits = (bits ^ bits >> 16) * 0x85ebca6bU;
  bits = (bits ^ bits >> 13) * 0xc2b2ae35U;
  return bits ^ bits >> 16;
}

}  // namespace

void SensorFaults::reserve(int width, int height) {
  const int reach = reach_of(kWidestBlur * height / kReferenceHeight);
  weights_.reserve(at(reach + 1));
  sums_.reserve(at(kChannels * width));
  row_.reserve(at(kChannels * (width + 2 * reach)));
  blurred_.reserve(at(kChannels * width) * at(height));
}

void SensorFaults::blur(const RenderImage& image, double sigma) {
  if (!(sigma > 0) || image.rgb == nullptr) return;
  set_weights(sigma * image.height / kReferenceHeight);
  sums_.resize(at(kChannels * image.width));
  blurred_.resize(sums_.size() * at(image.height));
  blur_rows(image);
  blur_columns(image);
}

// Rounded, with what is missing to one in the middle.
void SensorFaults::set_weights(double pixels) {
  weights_.assign(at(reach_of(pixels) + 1), 0);
  const auto bell = [&](std::size_t i) {
    const double at = static_cast<double>(i) / pixels;
    return real::exp(-0.5 * at * at);
  };
  double total = 1;
  for (std::size_t i = 1; i < weights_.size(); ++i) total += 2 * bell(i);
  std::uint32_t sides = 0;
  for (std::size_t i = 1; i < weights_.size(); ++i) {
    weights_[i] = static_cast<std::uint32_t>(std::lround(kOne * bell(i) / total));
    sides += 2 * weights_[i];
  }
  weights_[0] = kOne - sides;
}

void SensorFaults::blur_rows(const RenderImage& image) {
  const auto reach = static_cast<int>(weights_.size()) - 1;
  const std::size_t count = sums_.size();
  row_.resize(count + at(2 * kChannels * reach));
  for (int y = 0; y < image.height; ++y) {
    for (int x = -reach; x < image.width + reach; ++x) {
      const std::uint8_t* from = pixel(image, std::clamp(x, 0, image.width - 1), y);
      std::copy_n(from, kChannels, row_.data() + kChannels * (x + reach));
    }
    const std::uint8_t* middle = row_.data() + kChannels * reach;
    for (std::size_t i = 0; i < count; ++i) sums_[i] = kOne / 2 + weights_[0] * middle[i];
    for (std::size_t k = 1; k < weights_.size(); ++k) {
      const std::uint8_t* left = middle - kChannels * k;
      const std::uint8_t* right = middle + kChannels * k;
      const std::uint32_t weight = weights_[k];
      for (std::size_t i = 0; i < count; ++i) {
        sums_[i] += weight * (std::uint32_t{left[i]} + right[i]);
      }
    }
    std::uint8_t* out = blurred_.data() + at(y) * count;
    for (std::size_t i = 0; i < count; ++i) out[i] = static_cast<std::uint8_t>(sums_[i] / kOne);
  }
}

void SensorFaults::blur_columns(const RenderImage& image) {
  const std::size_t count = sums_.size();
  const auto row = [&](int y) {
    return blurred_.data() + at(std::clamp(y, 0, image.height - 1)) * count;
  };
  for (int y = 0; y < image.height; ++y) {
    const std::uint8_t* middle = row(y);
    for (std::size_t i = 0; i < count; ++i) sums_[i] = kOne / 2 + weights_[0] * middle[i];
    for (std::size_t k = 1; k < weights_.size(); ++k) {
      const std::uint8_t* above = row(y - static_cast<int>(k));
      const std::uint8_t* below = row(y + static_cast<int>(k));
      const std::uint32_t weight = weights_[k];
      for (std::size_t i = 0; i < count; ++i) {
        sums_[i] += weight * (std::uint32_t{above[i]} + below[i]);
      }
    }
    for (int x = 0; x < image.width; ++x) {
      std::uint8_t* out = pixel(image, x, y);
      for (int c = 0; c < kChannels; ++c) {
        out[c] = static_cast<std::uint8_t>(sums_[at(kChannels * x + c)] / kOne);
      }
    }
  }
}

// The sum of four uniform bytes is close to normal.
void SensorFaults::add_noise(const RenderImage& image, double deviation, std::uint64_t key) {
  if (!(deviation > 0) || image.rgb == nullptr) return;
  constexpr int kMeanOfBytes = 510;
  constexpr double kDeviationOfBytes = 147.80;  // sqrt(4 (256^2 - 1) / 12)
  const auto scale = static_cast<std::int32_t>(std::lround(kOne * deviation / kDeviationOfBytes));
  const auto low = static_cast<std::uint32_t>(key);
  const auto high = static_cast<std::uint32_t>(key >> 32);
  std::uint32_t index = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      std::uint8_t* out = pixel(image, x, y);
      for (int c = 0; c < kChannels; ++c) {
        const std::uint32_t bits = mixed(mixed(low + index++) ^ high);
        const auto sum = static_cast<std::int32_t>((bits & 255) + (bits >> 8 & 255) +
                                                   (bits >> 16 & 255) + (bits >> 24));
        const std::int32_t noise =
            ((sum - kMeanOfBytes) * scale + static_cast<std::int32_t>(kOne / 2)) >> 16;
        out[c] = static_cast<std::uint8_t>(std::clamp(out[c] + noise, 0, 255));
      }
    }
  }
}

}  // namespace engram
