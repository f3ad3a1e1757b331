#include "core/image/sensor_faults.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

namespace engram {
namespace {

// An image of one colour, with its pixels every `stride` bytes.
struct Sheet {
  Sheet(int width, int height, std::uint8_t level, int stride = 3)
      : bytes(static_cast<std::size_t>(width * height * stride), level) {
    image.width = width;
    image.height = height;
    image.rgb = bytes.data();
    image.pixel_stride = stride;
    image.row_stride = std::ptrdiff_t{stride} * width;
  }
  std::uint8_t& at(int x, int y, int channel = 0) {
    return image.rgb[y * image.row_stride + x * image.pixel_stride + channel];
  }

  std::vector<std::uint8_t> bytes;
  RenderImage image;
};

TEST_CASE("Blur leaves even colours alone, and spreads a point as a bell of its width",
          "[sensor_faults]") {
  SensorFaults faults;
  Sheet even(128, 128, 93);
  faults.blur(even.image, 1.5);
  CHECK(even.bytes == std::vector<std::uint8_t>(even.bytes.size(), 93));

  const double sigma = GENERATE(1.0, 2.0);
  Sheet line(128, 128, 0);
  for (int y = 0; y < 128; ++y) line.at(64, y) = 255;
  faults.blur(line.image, sigma);
  double sum = 0;
  double square = 0;
  for (int x = 0; x < 128; ++x) {
    sum += line.at(x, 60);
    square += line.at(x, 60) * (x - 64.0) * (x - 64.0);
    CHECK(int{line.at(x, 60, 1)} == 0);
  }
  CHECK(sum == Approx(255).margin(4));
  CHECK(std::sqrt(square / sum) == Approx(sigma).epsilon(0.03));
}

TEST_CASE("Blur is as wide in images of any size, in both directions", "[sensor_faults]") {
  SensorFaults faults;
  Sheet wide(64, 256, 0);
  for (int x = 0; x < 64; ++x) wide.at(x, 128) = 255;
  faults.blur(wide.image, 1.5);
  double sum = 0;
  double square = 0;
  for (int y = 0; y < 256; ++y) {
    sum += wide.at(30, y);
    square += wide.at(30, y) * (y - 128.0) * (y - 128.0);
  }
  CHECK(std::sqrt(square / sum) == Approx(2 * 1.5).epsilon(0.03));
}

TEST_CASE("Noise has the standard deviation asked for, and is a function of its key",
          "[sensor_faults]") {
  SensorFaults faults;
  Sheet first(128, 128, 128);
  faults.add_noise(first.image, 12, 77);
  double sum = 0;
  double square = 0;
  for (const std::uint8_t level : first.bytes) {
    sum += level - 128.0;
    square += (level - 128.0) * (level - 128.0);
  }
  const auto count = static_cast<double>(first.bytes.size());
  CHECK(sum / count == Approx(0).margin(0.3));
  CHECK(std::sqrt(square / count) == Approx(12).epsilon(0.02));

  Sheet again(128, 128, 128);
  SensorFaults().add_noise(again.image, 12, 77);
  CHECK(again.bytes == first.bytes);
  Sheet other(128, 128, 128);
  faults.add_noise(other.image, 12, 78);
  CHECK(other.bytes != first.bytes);
}

TEST_CASE("Faults touch only the image's own bytes", "[sensor_faults]") {
  SensorFaults faults;
  Sheet sheet(20, 10, 50, 6);
  faults.blur(sheet.image, 2);
  faults.add_noise(sheet.image, 30, 5);
  bool same = true;
  for (std::size_t i = 0; i < sheet.bytes.size(); ++i) same &= i % 6 < 3 || sheet.bytes[i] == 50;
  CHECK(same);
  const std::vector<std::uint8_t> before = sheet.bytes;
  faults.blur(sheet.image, 0);
  faults.add_noise(sheet.image, 0, 5);
  CHECK(sheet.bytes == before);
}

}  // namespace
}  // namespace engram
