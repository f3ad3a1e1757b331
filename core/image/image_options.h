// Options of image observations and of the images behind them.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace engram {

// Size and cameras of image observations.
struct ImageShape {
  // begin generated: shape (tools/surface, from api/surface.toml)
  // Width of rgb observations. 1 to 4096 pixels.
  int width = 128;
  // Height of rgb observations. 1 to 4096 pixels.
  int height = 128;
  // Cameras of rgb observations, in channel order.
  std::vector<std::string> cameras = {"base_camera", "hand_camera"};
  // end generated

  // Values of one environment's image with one value for each pixel and camera.
  std::size_t cells() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * cameras.size();
  }
};

struct ImageSourceOptions {
  // begin generated: source
  // Renderer of rgb observations. "cpu" or "egl".
  std::string renderer = "cpu";
  // Shadows in rgb observations.
  bool shadows = false;
  // 2 x 2 samples per pixel in rgb observations.
  bool antialias = false;
  // end generated
  int max_size = 128;       // pixels, of either side of an image
  bool for_people = true;   // false: leaves out what is hidden from the robot's sensors
  bool varies = false;      // what is seen has ImageChanges (core/image/image_changes.h)
  bool has_faults = false;  // images have noise or blur
};

}  // namespace engram
