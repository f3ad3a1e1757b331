// A small scene that tests fill with geoms, look at and take apart.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include "core/image/renderer.h"
#include "render/cpu/cpu_renderer.h"

namespace engram::test {

struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
  std::vector<float> depth;
  std::vector<std::int32_t> segment;

  std::size_t at(int x, int y) const { return static_cast<std::size_t>(y * width + x); }
  std::array<int, 3> color(int x, int y) const {
    const std::size_t i = 3 * at(x, y);
    return {rgb[i], rgb[i + 1], rgb[i + 2]};
  }
};

inline Eigen::Matrix3f look_along(const Eigen::Vector3f& forward, const Eigen::Vector3f& up_hint) {
  Eigen::Matrix3f rotation;
  rotation.col(2) = -forward.normalized();
  rotation.col(0) = forward.cross(up_hint).normalized();
  rotation.col(1) = rotation.col(2).cross(rotation.col(0));
  return rotation;
}

inline Eigen::Matrix3f turned(float angle, const Eigen::Vector3f& axis) {
  return Eigen::AngleAxisf(angle, axis.normalized()).toRotationMatrix();
}

// One camera with a right angle of view, at the origin, looking along +x with +z up, unless moved.
class RenderRig {
 public:
  RenderRig() {
    RenderCamera camera;
    camera.name = "camera";
    camera.fovy = std::numbers::pi_v<float> / 2;
    scene.cameras.push_back(camera);
    scene.ambient[0] = scene.ambient[1] = scene.ambient[2] = 0.5F;
    set_camera({0, 0, 0}, look_along({1, 0, 0}, {0, 0, 1}));
  }

  void set_camera(const Eigen::Vector3f& position, const Eigen::Matrix3f& rotation) {
    set_pose(camera_pose.data(), position, rotation);
  }

  // Returns the geom's segment: 1 for the first.
  int add(RenderShape shape, std::array<float, 3> size, const Eigen::Vector3f& position,
          const Eigen::Matrix3f& rotation = Eigen::Matrix3f::Identity(),
          std::array<float, 4> color = {1, 1, 1, 1}) {
    RenderGeom geom;
    geom.shape = shape;
    for (std::size_t k = 0; k < 3; ++k) geom.size[k] = size[k];
    geom.segment = static_cast<std::int32_t>(scene.geoms.size()) + 1;
    scene.geoms.push_back(geom);
    geom_pose.resize(12 * scene.geoms.size());
    set_pose(&geom_pose[12 * (scene.geoms.size() - 1)], position, rotation);
    rgba.insert(rgba.end(), color.begin(), color.end());
    emission.push_back(0);
    visible.push_back(1);
    return geom.segment;
  }

  void add_light(const Eigen::Vector3f& direction, float level, bool shadow = false) {
    RenderLight light;
    for (int k = 0; k < 3; ++k) {
      light.direction[k] = direction[k];
      light.color[k] = level;
    }
    light.casts_shadow = shadow;
    scene.lights.push_back(light);
  }

  RenderInstances instances() const {
    return {geom_pose.data(), rgba.data(), emission.data(), visible.data(), camera_pose.data()};
  }

  Image render(Renderer& renderer, int width = 64, int height = 64) const {
    Image drawn;
    drawn.width = width;
    drawn.height = height;
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    drawn.rgb.resize(3 * pixels);
    drawn.depth.resize(pixels);
    drawn.segment.resize(pixels);
    RenderImage image;
    image.width = width;
    image.height = height;
    image.rgb = drawn.rgb.data();
    image.row_stride = 3 * width;
    image.depth = drawn.depth.data();
    image.segment = drawn.segment.data();
    renderer.render(0, instances(), {&image, 1});
    return drawn;
  }

  Image render(int width = 64, int height = 64, const CpuRendererOptions& options = {}) const {
    return render(*make_cpu_renderer(scene, options, 1), width, height);
  }

  RenderScene scene;
  std::vector<float> geom_pose;
  std::vector<float> rgba;
  std::vector<float> emission;
  std::vector<std::uint8_t> visible;
  std::array<float, 12> camera_pose{};

 private:
  static void set_pose(float* pose, const Eigen::Vector3f& position,
                       const Eigen::Matrix3f& rotation) {
    Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>> to_rotation(pose);
    to_rotation = rotation;
    Eigen::Map<Eigen::Vector3f> to_position(pose + 9);
    to_position = position;
  }
};

// A unit cube scaled by these half extents, as a mesh.
inline RenderMesh box_mesh(float x, float y, float z) {
  RenderMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.push_back((i & 1) != 0 ? x : -x);
    mesh.vertices.push_back((i & 2) != 0 ? y : -y);
    mesh.vertices.push_back((i & 4) != 0 ? z : -z);
  }
  mesh.triangles = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                    2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return mesh;
}

// All shapes and patterns above a table and a floor.
inline RenderRig crowd(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> any(-1, 1);
  RenderRig rig;
  rig.scene.meshes.push_back(box_mesh(0.1F, 0.1F, 0.1F));
  rig.add(RenderShape::kPlane, {0, 0, 0}, {0, 0, -1});
  rig.scene.geoms.back().pattern = RenderPattern::kGrid;
  rig.add(RenderShape::kBox, {0.6F, 1.2F, 0.1F}, {0.3F, 0, -0.1F}, Eigen::Matrix3f::Identity(),
          {0.9F, 0.5F, 0.3F, 1});
  rig.scene.geoms.back().pattern = RenderPattern::kWood;
  for (int i = 0; i < 36; ++i) {
    rig.add(static_cast<RenderShape>(1 + i % 6), {0.04F, 0.06F, 0.05F},
            {0.3F + 0.4F * any(random), 0.5F * any(random), 0.2F + 0.2F * any(random)},
            turned(3 * any(random), {any(random), any(random), 1}),
            {0.5F + 0.5F * any(random), 0.5F, 0.5F + 0.5F * any(random), 1});
    rig.scene.geoms.back().mesh = 0;
  }
  rig.add_light({1, 1, -1}, 0.4F, true);
  rig.add_light({0, 0, -1}, 0.3F);
  rig.set_camera({-0.4F + 0.05F * any(random), 0, 0.5F}, look_along({1, 0.1F, -0.6F}, {0, 0, 1}));
  return rig;
}

}  // namespace engram::test
