// Images of single environments, on demand, for people and tools.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "core/batch/batch.h"
#include "core/image/overlay.h"

namespace engram {

// Compiles the scene for its renderer at the first image, so keep it for the next one.
class SceneRenderer {
 public:
  // The batch outlives this object.
  explicit SceneRenderer(const Batch& batch) : batch_(batch), views_(at(batch.num_parts())) {}

  // Draws environment `env` as it is now, row 0 on top: a sensor as observations show it, or
  // render_camera with the render_options. camera: one of the scene's (docs/robot.md);
  // sides 1 to 4096 pixels; rgb: (height, width, 3). Throws Error for anything else, or before the
  // first reset.
  void render(int env, std::string_view camera, int width, int height, std::span<std::uint8_t> rgb);

  // Adds the task's overlay for people: goals, counters, marks.
  void overlay(int env, Overlay& out) const;

 private:
  // Scenes of one task.
  struct Views {
    std::unique_ptr<SceneViews> bodies;
    std::unique_ptr<ImageSource> sensor_source;
    std::unique_ptr<ImageSource> render_source;
  };

  static ImageSource& source_for(const BatchData& data, Views& views, bool people);

  const Batch& batch_;
  std::vector<Views> views_;  // of each part
  SensorFaults faults_;
};

}  // namespace engram
