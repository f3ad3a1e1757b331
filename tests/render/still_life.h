// A scene of which some never moves, seen by two cameras.
#pragma once

#include <vector>

#include "tests/render/render_fixture.h"

namespace engram::test {

inline std::vector<InstructionSet> sets() {
  std::vector<InstructionSet> all;
  for (const InstructionSet set :
       {InstructionSet::kBaseline, InstructionSet::kAvx2, InstructionSet::kAvx512}) {
    if (is_supported(set)) all.push_back(set);
  }
  return all;
}

// Options of renderers that draw all sizes of these tests.
inline CpuRendererOptions with(InstructionSet set, bool antialias = false) {
  CpuRendererOptions options{
      .antialias = antialias, .instruction_set = set, .max_width = 1300, .max_height = 300};
  return options;
}

// Two cameras, the first of which never moves, nor do floor, table and every fifth geom.
inline RenderRig still_life(unsigned seed) {
  RenderRig rig = crowd(seed);
  for (std::size_t i = 0; i < rig.scene.geoms.size(); ++i) {
    rig.scene.geoms[i].still = i < 2 || i % 5 == 0;
  }
  rig.scene.cameras[0].still = true;
  rig.scene.cameras.push_back(rig.scene.cameras[0]);
  rig.scene.cameras[1].still = false;
  return rig;
}

inline RenderInstances two_cameras(const RenderRig& rig, std::vector<float>& poses) {
  poses.assign(rig.camera_pose.begin(), rig.camera_pose.end());
  poses.insert(poses.end(), rig.camera_pose.begin(), rig.camera_pose.end());
  poses[12 + 9] += 0.1F;
  poses[12 + 11] -= 0.15F;
  RenderInstances instances = rig.instances();
  instances.camera_pose = poses.data();
  return instances;
}

using Rgb = std::vector<std::uint8_t>;

// Colours of some cameras, as observations have them.
template <typename Source, typename... Where>
Rgb draw(Source& source, const std::vector<int>& cameras, int width, int height, bool with_depth,
         const Where&... where) {
  Rgb rgb(3 * cameras.size() * static_cast<std::size_t>(width * height), 77);
  std::vector<float> depth(static_cast<std::size_t>(width * height));
  std::vector<RenderImage> images;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    RenderImage image;
    image.camera = cameras[i];
    image.width = width;
    image.height = height;
    image.rgb = rgb.data() + 3 * i;
    image.pixel_stride = static_cast<std::ptrdiff_t>(3 * cameras.size());
    image.row_stride = image.pixel_stride * width;
    if (with_depth) image.depth = depth.data();
    images.push_back(image);
  }
  source.render(0, where..., images);
  return rgb;
}

}  // namespace engram::test
