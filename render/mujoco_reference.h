// MuJoCo's own renderer through EGL: what tests compare images with, and what benchmarks beat.
#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <memory>
#include <string>

namespace engram {

struct MujocoReferenceOptions {
  int max_width = 512;  // pixels
  int max_height = 512;
  // Tessellation of round shapes and planes; MuJoCo's defaults.
  int slices = 28;
  int stacks = 16;
  int quads = 4;
  int samples = 0;      // MSAA; 0: none. MuJoCo's default is 4
  int shadow_size = 0;  // texels; 0: none. MuJoCo's default is 4096
  // Only what RenderScene can describe: no specular light, no textures, no reflections.
  bool plain = false;
};

// Draws geoms of groups 0 to 2, from a copy of the model. For one thread at a time.
class MujocoReference {
 public:
  // Throws Error, kUnavailable where there is no EGL.
  MujocoReference(const mjModel& model, const MujocoReferenceOptions& options);
  ~MujocoReference();

  // The copy: colours and materials may be changed between images, geometry may not.
  mjModel& model();

  // Fills (height, width, 3) bytes and, unless null, (height, width) distances along the view axis
  // in m, 0 where there is nothing, and (height, width) indices of geoms plus 1, 0 where there is
  // nothing. Row 0 is the top one. `data` needs its kinematics and lights computed.
  // Throws Error if the camera does not exist or the size is out of range.
  void render(mjData& data, const std::string& camera, int width, int height, std::uint8_t* rgb,
              float* depth = nullptr, std::int32_t* segment = nullptr);

 private:
  struct Parts;
  void read_segments(int width, int height, std::int32_t* segment);

  std::unique_ptr<Parts> parts_;
};

}  // namespace engram
