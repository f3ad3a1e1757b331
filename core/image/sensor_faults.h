// Faults of a camera's sensor: blur and noise in images that are drawn already. In whole numbers,
// so that every processor gives the same.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image/renderer.h"

namespace engram {

// Memory of one thread.
class SensorFaults {
 public:
  // Makes room for images of that size. Their faults then allocate nothing.
  void reserve(int width, int height);

  // Blurs colours by a Gaussian kernel whose standard deviation is `sigma` pixels of an image 128
  // pixels high; beyond the edges, their pixels go on. Nothing for 0.
  void blur(const RenderImage& image, double sigma);

  // Adds noise of that standard deviation, in levels of 255, to every colour of every pixel: a
  // function of `key` and the pixel alone. Nothing for 0.
  void add_noise(const RenderImage& image, double deviation, std::uint64_t key);

 private:
  void set_weights(double pixels);
  void blur_rows(const RenderImage& image);
  void blur_columns(const RenderImage& image);

  std::vector<std::uint32_t> weights_;  // of the kernel's middle and of one side; 65536 in all
  std::vector<std::uint32_t> sums_;     // of a row
  std::vector<std::uint8_t> row_;       // with the kernel's width on both sides
  std::vector<std::uint8_t> blurred_;   // along rows
};

}  // namespace engram
