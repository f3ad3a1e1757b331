// The image of `engram record`: one camera, or the human view beside both sensors, for one
// environment of a batch.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "api/media.h"
#include "core/batch/scene_renderer.h"
#include "protocol/make/make.h"

namespace engram::apps {

struct ViewOptions {
  std::string camera = "all";  // base, hand, render or all
  int width = 0;               // pixels of a single camera; of all: three halves of the height
  int height = 0;
  int sensor_size = 0;  // of all: pixels that sensors draw, enlarged to their panels; 0: as large
  bool overlays = false;
};

class RecordView {
 public:
  // The batch outlives the view.
  RecordView(const Batch& batch, const ViewOptions& options);

  int width() const { return options_.width; }
  int height() const { return options_.height; }
  // The batch's first environment as it is now: (height, width, 3).
  std::vector<std::uint8_t> draw();

 private:
  struct Panel {
    int x, y, side;  // pixels
  };

  void draw_camera(const std::string& name, int width, int height);
  void draw_overlays(int width, int height, Canvas& canvas) const;
  void draw_panel(const std::string& camera, const std::string& label, const Panel& panel,
                  Canvas& canvas);

  const Batch& batch_;
  SceneRenderer renderer_;
  ViewOptions options_;
  std::vector<std::uint8_t> rgb_;  // of the last camera
};

}  // namespace engram::apps
