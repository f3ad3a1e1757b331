// Where pictures come from, as the engine sees it.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/image/renderer.h"

namespace engram {

// Where a body is and how it looks.
struct BodyView {
  double pos[3] = {0, 0, 0};      // m, world
  double quat[4] = {1, 0, 0, 0};  // w, x, y, z
  bool visible = true;
  // Colour that replaces the document's if its alpha is positive, 0..1, as displays want it; and
  // added emission.
  float rgba[4] = {0, 0, 0, 0};
  float emission = 0;
};

// Draws a scene document with its bodies put where they are in one environment.
class ImageSource {
 public:
  virtual ~ImageSource() = default;
  // Names, in the order in which RenderImage::camera counts them.
  virtual const std::vector<std::string>& cameras() const = 0;
  // What values of segmentation images stand for: index -> name. 0 is the background.
  virtual const std::vector<std::string>& segments() const = 0;
  // `bodies` in the order that the source was made for. Does not allocate, lock or throw.
  virtual void render(int worker, std::span<const BodyView> bodies,
                      std::span<const RenderImage> images) = 0;
};

// What image observations look like.
struct ImageShape {
  // begin options: shape (scripts/options.py writes this from api/options.toml)
  // Width of rgb observations. 1 to 4096 pixels.
  int width = 128;
  // Height of rgb observations. 1 to 4096 pixels.
  int height = 128;
  // Cameras of rgb observations, in channel order.
  std::vector<std::string> cameras = {"base_camera", "hand_camera"};
  // end options

  // Of one environment: values of a picture with one value for each pixel and camera.
  std::size_t cells() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * cameras.size();
  }
};

struct ImageSourceOptions {
  // begin options: source
  // Renderer of rgb observations. "cpu" or "egl".
  std::string renderer = "cpu";
  // Shadows in rgb observations.
  bool shadows = false;
  // 2 x 2 samples per pixel in rgb observations.
  bool antialias = false;
  // end options
  int max_size = 128;      // pixels, of either side of an image
  bool for_people = true;  // false: leaves out what is hidden from the robot's sensors
};

// Makes a source for an MJCF document; `bodies` names what BodyViews stand for. Throws Error if
// the renderer does not exist or cannot work here.
using ImageSourceFactory = std::function<std::unique_ptr<ImageSource>(
    const std::string& document, const std::vector<std::string>& bodies,
    const ImageSourceOptions& options, int workers)>;

}  // namespace engram
