// Renderer interface: flat arrays in, pixels out.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/image/image_options.h"

namespace engram {

enum class RenderShape : std::uint8_t {
  kPlane,      // z = 0 of its frame, seen from above; size: half extents x, y; 0 is infinite
  kSphere,     // size: radius
  kCapsule,    // radius, half length of the cylindrical part along z
  kEllipsoid,  // three radii
  kCylinder,   // radius, half length along z
  kBox,        // three half extents
  kMesh,       // convex; index `mesh`
};

// Procedural surface patterns, multiplied with the geom's colour.
enum class RenderPattern : std::uint8_t { kPlain, kWood, kGrid };

// Constants of a geom in all environments.
struct RenderGeom {
  RenderShape shape = RenderShape::kBox;
  float size[3] = {};
  int mesh = -1;
  RenderPattern pattern = RenderPattern::kPlain;
  bool still = false;        // visible, in one place and in one colour in all images
  std::int32_t segment = 0;  // value in segmentation images; 0 is the background
};

// The convex hull of points, in the geom's frame.
struct RenderMesh {
  std::vector<float> vertices;          // (n, 3)
  std::vector<std::int32_t> triangles;  // (m, 3), counter-clockwise seen from outside
};

struct RenderCamera {
  std::string name;
  float fovy = 0;           // vertical, rad
  float near_clip = 0.01F;  // m
  float far_clip = 100.0F;
  bool still = false;  // in one place in all environments and images
};

struct RenderLight {
  float direction[3] = {0, 0, -1};  // of the light's rays; need not be normalised
  float color[3] = {1, 1, 1};
  bool casts_shadow = false;
};

// Lights of one environment instead of the scene's; as many, which cast shadows as those do.
struct RenderLighting {
  std::vector<RenderLight> lights;
  float ambient[3] = {};
};

// What a patterned geom of the scene shows in one environment.
struct RenderSurface {
  RenderPattern pattern = RenderPattern::kPlain;
  bool turned = false;  // along and across change places
  float scale = 1;      // above 1: the pattern is finer
};

struct RenderScene {
  std::vector<RenderGeom> geoms;
  std::vector<RenderMesh> meshes;
  std::vector<RenderCamera> cameras;
  std::vector<RenderLight> lights;
  float ambient[3] = {0.3F, 0.3F, 0.3F};
  float background[3] = {0, 0, 0};
};

// One environment's rows. A pose is a rotation, row by row, then a position (12 floats), from the
// geom's or camera's frame to the world. Cameras look along -z, with +x right and +y up.
struct RenderInstances {
  const float* geom_pose = nullptr;            // (geoms, 12)
  const float* geom_rgba = nullptr;            // (geoms, 4), 0..1; alpha 0 hides
  const float* geom_emission = nullptr;        // (geoms), 0: lit by the lights only
  const std::uint8_t* geom_visible = nullptr;  // (geoms)
  const float* camera_pose = nullptr;          // (cameras, 12)
  // Departures from the scene; null: none. For cameras and geoms that are not still.
  const float* camera_fovy = nullptr;           // (cameras) rad
  const RenderLighting* lighting = nullptr;     // lights as many as the scene's
  const RenderSurface* geom_surface = nullptr;  // (geoms); counts where the scene has a pattern
};

// One image. Row 0 is the top one.
struct RenderImage {
  int camera = 0;
  int width = 128;  // pixels
  int height = 128;
  std::uint8_t* rgb = nullptr;      // first pixel; may be null
  std::ptrdiff_t pixel_stride = 3;  // bytes from pixel to pixel
  std::ptrdiff_t row_stride = 384;  // bytes from row to row
  float* depth = nullptr;           // (height, width) m along the view axis; 0: nothing there
  std::int32_t* segment = nullptr;  // (height, width)
  // Both once more, as observations have them: at row y and column x, element y * cell_row + x *
  // cell_step. Depth to the nearest millimetre, 32767 at most.
  std::int16_t* depth_mm = nullptr;
  std::int16_t* segment_id = nullptr;
  std::ptrdiff_t cell_step = 1;
  std::ptrdiff_t cell_row = 128;
};

// Depth as observations have it, from metres.
inline std::int16_t to_millimetres(float depth) {
  constexpr float kMax = 32767;
  const float exact = 1000 * depth;
  return static_cast<std::int16_t>(exact < kMax ? std::lrint(exact) : 32767);
}

// Renders environments one at a time; different workers may render at the same time. The scene is
// given when a renderer is made.
class Renderer {
 public:
  virtual ~Renderer() = default;
  virtual const char* name() const = 0;
  // Does not allocate, lock or throw. `worker` is below the number that the renderer was made for.
  virtual void render(int worker, const RenderInstances& instances,
                      std::span<const RenderImage> images) = 0;
};

// Throws Error if the renderer does not exist or cannot work here.
using RendererFactory = std::function<std::unique_ptr<Renderer>(
    const RenderScene& scene, const ImageSourceOptions& options, int workers)>;

}  // namespace engram
