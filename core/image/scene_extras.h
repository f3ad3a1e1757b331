// Distractors and a post in images of a changed scene. They are drawn
// only; physics and tasks do not know them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/image/image_changes.h"

namespace engram {

class SceneExtras {
 public:
  SceneExtras() = default;
  // Adds their geoms to a scene; their segments follow those in `names`.
  SceneExtras(RenderScene& scene, std::vector<std::string>& names);

  // Fills in their rows, which begin at the number of geoms that the scene had: poses (12), colours
  // (4) and visibility.
  void place(const ImageChanges& changes, float* geom_pose, float* geom_rgba,
             std::uint8_t* geom_visible) const;

 private:
  std::size_t first_ = 0;
};

}  // namespace engram
