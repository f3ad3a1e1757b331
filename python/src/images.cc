// What data sets need of every pixel.
#include "images.h"

#include <nanobind/ndarray.h>

#include <cstdint>
#include <string>
#include <vector>

#include "batch.h"
#include "calls.h"

namespace engram_python {
namespace {

using namespace nb::literals;  // NOLINT: the way in which nanobind's literals are meant to be used

// (T, H, W, C). Neighbours need not be contiguous: a camera's channels may lie among another's.
template <class T>
using Images = nb::ndarray<const T, nb::ndim<4>, nb::device::cpu>;
template <class T, int Dims>
using In = nb::ndarray<const T, nb::ndim<Dims>, nb::c_contig, nb::device::cpu>;
template <class T, int Dims>
using Out = nb::ndarray<T, nb::ndim<Dims>, nb::c_contig, nb::device::cpu>;

void require(bool allowed, const char* needed) {
  if (!allowed) raise(ENGRAM_INVALID_ARGUMENT, (std::string(needed) + " needed").c_str());
}

template <class T>
const T* line_of(const Images<T>& images, std::size_t image, std::size_t y) {
  return images.data() + static_cast<std::int64_t>(image) * images.stride(0) +
         static_cast<std::int64_t>(y) * images.stride(1);
}

// The nearest whole number, ties to even, of one from 0 to 255.
std::uint8_t rounded(float value) {
  constexpr float kFirstWithoutFraction = 8388608;  // 2^23
  return static_cast<std::uint8_t>(value + kFirstWithoutFraction - kFirstWithoutFraction);
}

// Two lines of an image, a channel in each row, and what follows from them.
struct Lines {
  explicit Lines(std::size_t width) : rgb(6 * width), sums(3 * width / 2), width(width) {}

  void read(const Images<std::uint8_t>& images, std::size_t image, std::size_t y) {
    for (std::size_t line = 0; line < 2; ++line) {
      float* const row = &rgb[3 * line * width];
      const std::uint8_t* pixel = line_of(images, image, y + line);
      const std::int64_t next = images.stride(2);
      const std::int64_t next_channel = images.stride(3);
      for (std::size_t x = 0; x < width; ++x, pixel += next) {
        row[x] = pixel[0];
        row[width + x] = pixel[next_channel];
        row[2 * width + x] = pixel[2 * next_channel];
      }
    }
  }

  void write_luma(std::size_t line, const float* weights, float offset,
                  std::uint8_t* __restrict out) const {
    const float* const row = &rgb[3 * line * width];
    const float r = weights[0], g = weights[1], b = weights[2];
    for (std::size_t x = 0; x < width; ++x) {
      out[x] = rounded(row[x] * r + row[width + x] * g + row[2 * width + x] * b + offset);
    }
  }

  // Means of squares of four pixels.
  void write_chroma(const float* weights, float offset, std::uint8_t* __restrict out) const {
    const float r = weights[0] / 4, g = weights[1] / 4, b = weights[2] / 4;
    const float* const row = sums.data();
    for (std::size_t x = 0; x < width / 2; ++x) {
      out[x] = rounded(row[x] * r + row[width / 2 + x] * g + row[width + x] * b + offset);
    }
  }

  void add_squares() {
    for (std::size_t c = 0; c < 3; ++c) {
      const float* const above = &rgb[c * width];
      const float* const below = above + 3 * width;
      float* const sum = &sums[c * width / 2];
      for (std::size_t x = 0; x < width / 2; ++x) {
        sum[x] = above[2 * x] + below[2 * x] + above[2 * x + 1] + below[2 * x + 1];
      }
    }
  }

  std::vector<float> rgb;
  std::vector<float> sums;  // of squares of four pixels
  std::size_t width;
};

// FFmpeg's yuv420p of images of three channels: the lines of Y, then those of U and V at half the
// size. A row of `matrix` and a number of `offset` for each of them.
void to_yuv420(const Images<std::uint8_t>& images, const In<float, 2>& matrix,
               const In<float, 1>& offset, const Out<std::uint8_t, 3>& out) {
  const std::size_t height = images.shape(1);
  const std::size_t width = images.shape(2);
  require(height % 2 == 0 && width % 2 == 0 && images.shape(3) == 3,
          "images: three channels, even height and width");
  require(matrix.shape(0) == 3 && matrix.shape(1) == 3, "matrix: (3, 3)");
  require(offset.shape(0) == 3, "offset: (3,)");
  require(
      out.shape(0) == images.shape(0) && out.shape(1) == height * 3 / 2 && out.shape(2) == width,
      "out: (T, H * 3 / 2, W)");
  Lines lines(width);
  without_lock([&] {
    const float* const weights = matrix.data();
    for (std::size_t image = 0; image < images.shape(0); ++image) {
      std::uint8_t* const planes = out.data() + image * height * width * 3 / 2;
      std::uint8_t* const u = planes + height * width;
      std::uint8_t* const v = u + height * width / 4;
      for (std::size_t y = 0; y < height; y += 2) {
        lines.read(images, image, y);
        for (std::size_t line = 0; line < 2; ++line) {
          lines.write_luma(line, weights, offset.data()[0], planes + (y + line) * width);
        }
        lines.add_squares();
        lines.write_chroma(weights + 3, offset.data()[1], u + y * width / 4);
        lines.write_chroma(weights + 6, offset.data()[2], v + y * width / 4);
      }
    }
  });
}

// Adds how often each level is in these images, by channel, to counts (C, levels).
template <class T>
void count_levels(const Images<T>& images, const In<std::int64_t, 1>& chosen,
                  const Out<std::int64_t, 2>& counts) {
  const std::size_t channels = images.shape(3);
  require(counts.shape(0) == channels && counts.shape(1) == std::size_t{1} << 8 * sizeof(T),
          "counts: (C, levels)");
  for (std::size_t i = 0; i < chosen.shape(0); ++i) {
    require(static_cast<std::size_t>(chosen.data()[i]) < images.shape(0),
            "chosen: images' indices");
  }
  without_lock([&] {
    const std::size_t levels = counts.shape(1);
    const std::size_t width = images.shape(2);
    const std::int64_t next = images.stride(2);
    for (std::size_t i = 0; i < chosen.shape(0); ++i) {
      const auto image = static_cast<std::size_t>(chosen.data()[i]);
      for (std::size_t y = 0; y < images.shape(1); ++y) {
        for (std::size_t c = 0; c < channels; ++c) {
          const T* pixel =
              line_of(images, image, y) + static_cast<std::int64_t>(c) * images.stride(3);
          std::int64_t* const row = counts.data() + c * levels;
          for (std::size_t x = 0; x < width; ++x, pixel += next) ++row[*pixel];
        }
      }
    }
  });
}

}  // namespace

void bind_images(nb::module_& module) {
  module.def("to_yuv420", &to_yuv420, "images"_a.noconvert(), "matrix"_a, "offset"_a,
             "out"_a.noconvert());
  module.def("count_levels", &count_levels<std::uint8_t>, "images"_a.noconvert(), "chosen"_a,
             "counts"_a.noconvert());
  module.def("count_levels", &count_levels<std::uint16_t>, "images"_a.noconvert(), "chosen"_a,
             "counts"_a.noconvert());
}

}  // namespace engram_python
