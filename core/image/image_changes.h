// Departures of one environment's images from its scene: cameras, lights, surfaces, things that
// are added to the scene, and faults of the sensor. All zero: none.
#pragma once

#include <array>
#include <cstdint>

#include "core/image/renderer.h"
#include "core/math/frame.h"

namespace engram {

// The cameras that observations have.
enum SensorCamera : std::uint8_t { kBaseCamera, kHandCamera };
inline constexpr std::array kSensorCameraNames = {"base_camera", "hand_camera"};

// In the camera's own axes: right, up, backward.
struct CameraChange {
  std::array<double, 3> offset = {};    // m
  std::array<double, 3> rotation = {};  // rad, about backward, then up, then right
  double fovy = 0;                      // rad, added
};

// The camera's frame with that change.
Frame moved(const Frame& camera, const CameraChange& change);

struct LightChange {
  double brightness = 0;             // added to the factor of all light
  std::array<double, 3> color = {};  // added to the factor of each colour
  double azimuth = 0;                // rad, by which the slanted light turns about the vertical
  double elevation = 0;              // rad, by which it rises
};

struct SurfaceChange {
  std::array<float, 3> color = {};  // added to the factor of each colour
  RenderSurface surface;
};

// Something that stands on the table beside what the task is about: seen, but not touched.
struct Distractor {
  std::array<double, 2> shift = {};  // -1 to 1: x and y within its own part of the table
  double turn = 0;                   // rad, about the vertical
  int color = 0;                     // below kDistractorColors
};

inline constexpr double kMaxNoiseLevels = 30;
inline constexpr double kWidestBlur = 2;
inline constexpr int kMaxDistractors = 6;
inline constexpr int kDistractorColors = 8;

struct ImageChanges {
  bool cameras = false;
  std::array<CameraChange, kSensorCameraNames.size()> camera = {};
  bool lights = false;
  LightChange light;
  bool table = false;  // and ground: these have a change
  SurfaceChange table_surface;
  bool ground = false;
  SurfaceChange ground_surface;
  int distractor_count = 0;
  std::array<Distractor, kMaxDistractors> distractors = {};
  // A post between the base camera and what it looks at: its width as a share of the widest one's,
  // 0: none, and its y, m.
  double post_width = 0;
  double post_y = 0;
  // Standard deviations of colours in images of sensors: of noise in levels of 255, at most
  // kMaxNoiseLevels, and of the blur's kernel in pixels of an image 128 pixels high, at most
  // kWidestBlur.
  double noise = 0;
  double blur = 0;
};

}  // namespace engram
