#include "core/image/scene_extras.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/index.h"
#include "core/math/real_functions.h"

namespace engram {
namespace {

// Shapes and colours that no task has: nothing to remember is a capsule or an ellipsoid, or grey,
// brown or cream.
struct DistractorShape {
  const char* name;
  RenderShape shape;
  std::array<float, 3> size;
  bool lies;      // its z axis is level
  double height;  // of its middle above the table, m
};
constexpr std::array<DistractorShape, kMaxDistractors> kShapes = {{
    {"marker", RenderShape::kCapsule, {0.016F, 0.045F, 0}, true, 0.016},
    {"stone", RenderShape::kEllipsoid, {0.045F, 0.032F, 0.024F}, false, 0.024},
    {"bottle", RenderShape::kCapsule, {0.022F, 0.035F, 0}, false, 0.057},
    {"dish", RenderShape::kEllipsoid, {0.055F, 0.055F, 0.012F}, false, 0.012},
    {"pen", RenderShape::kCapsule, {0.008F, 0.060F, 0}, true, 0.008},
    {"egg", RenderShape::kEllipsoid, {0.026F, 0.026F, 0.034F}, false, 0.034},
}};
constexpr std::array<std::array<float, 3>, kDistractorColors> kColors = {{{0.86F, 0.80F, 0.68F},
                                                                          {0.36F, 0.40F, 0.44F},
                                                                          {0.68F, 0.55F, 0.40F},
                                                                          {0.17F, 0.17F, 0.18F},
                                                                          {0.74F, 0.62F, 0.60F},
                                                                          {0.80F, 0.80F, 0.78F},
                                                                          {0.42F, 0.34F, 0.27F},
                                                                          {0.58F, 0.62F, 0.56F}}};

// Each has a part of the table beside the robot to itself. Seen from the base camera that is behind
// everything that tasks use, whose props keep to x > -0.36, so that nothing is hidden.
constexpr double kMiddleX = -0.49;  // m
constexpr double kReachX = 0.05;
constexpr std::array kMiddleY = {0.27, 0.40, 0.53};
constexpr double kReachY = 0.02;

// The post stands between the base camera, at x = 0.3, and the objects: one of several, each wider
// than the one before, since a geom's size is the same in all environments.
constexpr int kPosts = 8;
constexpr double kWidestPost = 0.020;  // half of it, m
constexpr double kPostX = 0.17;
constexpr float kPostHalfHeight = 0.25F;
constexpr float kPostHalfDepth = 0.004F;
constexpr std::array<float, 4> kPostColor = {0.30F, 0.30F, 0.32F, 1};

// Writes a pose: axes turned about the vertical; `lies`: the z axis points along the turned x axis.
void write_pose(double turn, bool lies, const Vec3& position, float* out) {
  const double c = real::cos(turn);
  const double s = real::sin(turn);
  Mat3 axes;
  if (lies) {
    axes << 0, -s, c, 0, c, s, -1, 0, 0;
  } else {
    axes << c, -s, 0, s, c, 0, 0, 0, 1;
  }
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      out[3 * row + column] = static_cast<float>(axes(row, column));
    }
    out[9 + row] = static_cast<float>(position[row]);
  }
}

}  // namespace

SceneExtras::SceneExtras(RenderScene& scene, std::vector<std::string>& names)
    : first_(scene.geoms.size()) {
  const auto add = [&](RenderShape shape, const std::array<float, 3>& size, std::int32_t segment) {
    RenderGeom geom;
    geom.shape = shape;
    std::ranges::copy(size, geom.size);
    geom.segment = segment;
    scene.geoms.push_back(geom);
  };
  for (const DistractorShape& each : kShapes) {
    add(each.shape, each.size, static_cast<std::int32_t>(names.size()));
    names.emplace_back(each.name);
  }
  const auto segment = static_cast<std::int32_t>(names.size());
  names.emplace_back("post");
  for (int i = 1; i <= kPosts; ++i) {
    const auto half_width = static_cast<float>(kWidestPost * i / kPosts);
    add(RenderShape::kBox, {kPostHalfDepth, half_width, kPostHalfHeight}, segment);
  }
}

void SceneExtras::place(const ImageChanges& changes, float* geom_pose, float* geom_rgba,
                        std::uint8_t* geom_visible) const {
  for (int i = 0; i < kMaxDistractors; ++i) {
    const std::size_t geom = first_ + at(i);
    geom_visible[geom] = i < changes.distractor_count ? 1 : 0;
    if (i >= changes.distractor_count) continue;
    const Distractor& distractor = changes.distractors[at(i)];
    const DistractorShape& shape = kShapes[at(i)];
    const double side = i % 2 == 0 ? 1 : -1;
    const double middle = kMiddleY[at(i / 2)];
    const Vec3 position(kMiddleX + kReachX * distractor.shift[0],
                        side * middle + kReachY * distractor.shift[1], shape.height);
    write_pose(distractor.turn, shape.lies, position, geom_pose + 12 * geom);
    std::ranges::copy(kColors[at(distractor.color)], geom_rgba + 4 * geom);
    geom_rgba[4 * geom + 3] = 1;
  }
  const auto width = static_cast<int>(std::ceil(kPosts * changes.post_width));
  for (int i = 1; i <= kPosts; ++i) {
    const std::size_t geom = first_ + kMaxDistractors + at(i) - 1;
    geom_visible[geom] = i == width ? 1 : 0;
    if (i != width) continue;
    write_pose(0, false, {kPostX, changes.post_y, static_cast<double>(kPostHalfHeight)},
               geom_pose + 12 * geom);
    std::ranges::copy(kPostColor, geom_rgba + 4 * geom);
  }
}

}  // namespace engram
