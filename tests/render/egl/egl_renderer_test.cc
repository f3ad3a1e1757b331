// The OpenGL renderer against the ray caster, and what it promises by itself.
#include "render/egl/egl_renderer.h"

#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "render/cpu/cpu_renderer.h"
#include "render/egl/context.h"
#include "tests/render/has_egl.h"

namespace engram {
namespace {

RenderMesh octahedron() {
  RenderMesh mesh;
  mesh.vertices = {0.2F, 0, 0, -0.2F, 0, 0, 0, 0.3F, 0, 0, -0.3F, 0, 0, 0, 0.15F, 0, 0, -0.15F};
  for (const int z : {4, 5}) {
    for (int k = 0; k < 4; ++k) {
      constexpr int kRing[] = {0, 2, 1, 3};
      const int a = kRing[k];
      const int b = kRing[(k + 1) % 4];
      mesh.triangles.insert(mesh.triangles.end(), {z, z == 4 ? a : b, z == 4 ? b : a});
    }
  }
  return mesh;
}

// A scene with the rows of one environment.
struct Stage {
  RenderScene scene;
  std::vector<float> pose, rgba, emission, camera_pose;
  std::vector<std::uint8_t> visible;

  RenderInstances rows() const {
    return {pose.data(), rgba.data(), emission.data(), visible.data(), camera_pose.data()};
  }
};

using Random = std::mt19937;

float uniform(Random& random, float low, float high) {
  return low + (high - low) * static_cast<float>(random()) / 4294967296.0F;
}

Eigen::Matrix3f random_rotation(Random& random) {
  const Eigen::Quaternionf q(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1),
                             uniform(random, -1, 1));
  return q.normalized().toRotationMatrix();
}

void append_pose(const Eigen::Matrix3f& rotation, const Eigen::Vector3f& position,
                 std::vector<float>& poses) {
  for (int row = 0; row < 3; ++row) {
    for (int k = 0; k < 3; ++k) poses.push_back(rotation(row, k));
  }
  poses.insert(poses.end(), position.data(), position.data() + 3);
}

void add_geom(Stage& stage, const RenderGeom& geom, const Eigen::Matrix3f& rotation,
              const Eigen::Vector3f& position, Random& random) {
  stage.scene.geoms.push_back(geom);
  stage.scene.geoms.back().segment = static_cast<std::int32_t>(stage.scene.geoms.size());
  append_pose(rotation, position, stage.pose);
  for (int k = 0; k < 3; ++k) stage.rgba.push_back(uniform(random, 0.1F, 1));
  stage.rgba.push_back(1);
  stage.emission.push_back(uniform(random, 0, 0.2F));
  stage.visible.push_back(1);
}

void add_camera(Stage& stage, const Eigen::Vector3f& eye, float fovy) {
  const Eigen::Vector3f back = eye.normalized();
  const Eigen::Vector3f right = Eigen::Vector3f::UnitZ().cross(back).normalized();
  Eigen::Matrix3f axes;
  axes << right, back.cross(right), back;
  RenderCamera camera;
  camera.name = "camera" + std::to_string(stage.scene.cameras.size());
  camera.fovy = fovy;
  stage.scene.cameras.push_back(camera);
  append_pose(axes, eye, stage.camera_pose);
}

// Shapes of every kind above a floor, seen from three sides; the third camera is among them.
Stage random_stage(unsigned seed, bool patterns) {
  Random random(seed);
  Stage stage;
  stage.scene.meshes.push_back(octahedron());
  stage.scene.ambient[1] = 0.35F;
  stage.scene.lights.resize(2);
  stage.scene.lights[0] = {{1, 1, -1}, {0.5F, 0.4F, 0.3F}, true};
  stage.scene.lights[1] = {{0, 0.2F, -2}, {0.2F, 0.3F, 0.4F}, false};
  for (int i = 0; i < 14; ++i) {
    RenderGeom geom;
    geom.shape = static_cast<RenderShape>(1 + i % 6);
    for (float& size : geom.size) size = uniform(random, 0.03F, 0.25F);
    if (geom.shape == RenderShape::kMesh) geom.mesh = 0;
    if (patterns && geom.shape == RenderShape::kBox) geom.pattern = RenderPattern::kWood;
    const Eigen::Vector3f position(uniform(random, -0.8F, 0.8F), uniform(random, -0.8F, 0.8F),
                                   uniform(random, -0.2F, 0.8F));
    add_geom(stage, geom, random_rotation(random), position, random);
  }
  RenderGeom floor;
  floor.shape = RenderShape::kPlane;
  floor.size[1] = seed % 2 == 0 ? 0.0F : 2.0F;
  if (patterns) floor.pattern = RenderPattern::kGrid;
  add_geom(stage, floor, Eigen::Matrix3f::Identity(), {0, 0, -0.3F}, random);
  const float angle = uniform(random, 0, 6);
  add_camera(stage, {2 * std::cos(angle), 2 * std::sin(angle), 1}, 0.8F);
  add_camera(stage, {1.2F * std::cos(angle), -1.2F * std::sin(angle), 0.5F}, 1.57F);
  add_camera(stage, {0.4F * std::sin(angle), 0.4F * std::cos(angle), 0.3F}, 1.2F);
  return stage;
}

struct Image {
  Image(int width_in, int height_in) : width(width_in), height(height_in) {
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    rgb.resize(3 * pixels);
    depth.resize(pixels);
    segment.resize(pixels);
  }
  RenderImage image(int camera) {
    return {camera, width, height, rgb.data(), 3, 3 * width, depth.data(), segment.data()};
  }
  int width, height;
  std::vector<std::uint8_t> rgb;
  std::vector<float> depth;
  std::vector<std::int32_t> segment;
};

Image draw(Renderer& renderer, const Stage& stage, int camera, int width, int height) {
  Image drawn(width, height);
  const RenderImage image = drawn.image(camera);
  renderer.render(0, stage.rows(), {&image, 1});
  return drawn;
}

struct Difference {
  double color = 0;       // mean absolute, of 255
  double silhouette = 0;  // pixels of another geom
  double depth = 0;       // 99th percentile of relative ones, where geoms agree
};

Difference compare(const Image& a, const Image& b) {
  Difference result;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) result.color += std::abs(a.rgb[i] - b.rgb[i]);
  result.color /= static_cast<double>(a.rgb.size());
  std::vector<double> depths;
  for (std::size_t i = 0; i < a.segment.size(); ++i) {
    if (a.segment[i] != b.segment[i]) {
      result.silhouette += 1;
    } else if (a.segment[i] != 0) {
      depths.push_back(std::abs(a.depth[i] / b.depth[i] - 1));
    }
  }
  result.silhouette /= static_cast<double>(a.segment.size());
  // At outlines rays graze, and depth is not worth comparing.
  if (depths.empty()) return result;
  const auto at = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() * 99 / 100);
  std::nth_element(depths.begin(), at, depths.end());
  result.depth = *at;
  return result;
}

Difference compare_renderers(bool patterns, int width, int height) {
  Difference mean;
  constexpr unsigned kScenes = 8;
  for (unsigned seed = 1; seed <= kScenes; ++seed) {
    const Stage stage = random_stage(seed, patterns);
    const auto cpu = make_cpu_renderer(stage.scene, {}, 1);
    const auto egl = make_egl_renderer(stage.scene, {}, 1);
    for (int camera = 0; camera < 3; ++camera) {
      const Difference difference = compare(draw(*egl, stage, camera, width, height),
                                            draw(*cpu, stage, camera, width, height));
      mean.color += difference.color / (3 * kScenes);
      mean.silhouette += difference.silhouette / (3 * kScenes);
      mean.depth = std::max(mean.depth, difference.depth);
    }
  }
  return mean;
}

}  // namespace

TEST_CASE("The OpenGL renderer draws what the ray caster draws", "[render][egl]") {
  if (!has_egl()) return;
  const Difference plain = compare_renderers(false, 128, 128);
  CAPTURE(plain.color, plain.silhouette, plain.depth);
  CHECK(plain.color <= 0.1);
  CHECK(plain.silhouette <= 0.001);
  CHECK(plain.depth <= 5e-3);
}

TEST_CASE("The OpenGL renderer has the ray caster's patterns", "[render][egl]") {
  if (!has_egl()) return;
  const Difference patterned = compare_renderers(true, 160, 96);
  CAPTURE(patterned.color, patterned.silhouette, patterned.depth);
  CHECK(patterned.color <= 0.5);
  CHECK(patterned.silhouette <= 0.001);
}

TEST_CASE("A finer tolerance brings OpenGL's outlines closer to exact ones", "[render][egl]") {
  if (!has_egl()) return;
  const Stage stage = random_stage(3, false);
  const auto cpu = make_cpu_renderer(stage.scene, {}, 1);
  const Image exact = draw(*cpu, stage, 0, 256, 256);
  double previous = 1;
  for (const float tolerance : {3.0F, 0.5F, 0.05F}) {
    const EglRendererOptions options{.tolerance = tolerance};
    const auto egl = make_egl_renderer(stage.scene, options, 1);
    const double silhouette = compare(draw(*egl, stage, 0, 256, 256), exact).silhouette;
    CHECK(silhouette < previous);
    previous = silhouette;
  }
}

TEST_CASE("OpenGL's soft shadows fall where the ray caster's do", "[render][egl]") {
  if (!has_egl()) return;
  const Stage stage = random_stage(2, false);
  const CpuRendererOptions cpu_options{.shadow_rays = 32};
  const EglRendererOptions egl_options{.shadows = true};
  const auto cpu = make_cpu_renderer(stage.scene, cpu_options, 1);
  const auto egl = make_egl_renderer(stage.scene, egl_options, 1);
  const auto unshadowed = make_egl_renderer(stage.scene, {}, 1);
  for (int camera = 0; camera < 2; ++camera) {
    const Image exact = draw(*cpu, stage, camera, 128, 128);
    const double with = compare(draw(*egl, stage, camera, 128, 128), exact).color;
    const double without = compare(draw(*unshadowed, stage, camera, 128, 128), exact).color;
    CAPTURE(with, without);
    CHECK(with < 0.2 * without);
  }
}

TEST_CASE("Multisampling smooths outlines and leaves the rest alone", "[render][egl]") {
  if (!has_egl()) return;
  const Stage stage = random_stage(5, true);
  const CpuRendererOptions cpu_options{.antialias = true};
  const EglRendererOptions egl_options{.samples = 4};
  const auto cpu = make_cpu_renderer(stage.scene, cpu_options, 1);
  const auto smooth = make_egl_renderer(stage.scene, egl_options, 1);
  const auto sharp = make_egl_renderer(stage.scene, {}, 1);
  const Image wanted = draw(*cpu, stage, 0, 128, 128);
  const double with = compare(draw(*smooth, stage, 0, 128, 128), wanted).color;
  const double without = compare(draw(*sharp, stage, 0, 128, 128), wanted).color;
  CAPTURE(with, without);
  CHECK(with < 0.5 * without);
}

TEST_CASE("OpenGL images obey strides, visibility and sizes", "[render][egl]") {
  if (!has_egl()) return;
  Stage stage = random_stage(4, false);
  const EglRendererOptions options{.max_width = 64};
  const auto egl = make_egl_renderer(stage.scene, options, 1);
  const Image packed = draw(*egl, stage, 1, 64, 32);

  // Six sizes: more than the renderer keeps framebuffers for.
  for (int width = 10; width <= 60; width += 10) draw(*egl, stage, 1, width, 32);
  CHECK(draw(*egl, stage, 1, 64, 32).rgb == packed.rgb);

  std::vector<std::uint8_t> bytes(32 * 500, 7);
  const RenderImage spread = {1, 64, 32, bytes.data() + 3, 6, 500, nullptr, nullptr};
  egl->render(0, stage.rows(), {&spread, 1});
  bool same = true;
  for (std::size_t y = 0; y < 32; ++y) {
    for (std::size_t x = 0; x < 64; ++x) {
      for (std::size_t k = 0; k < 3; ++k) {
        same = same && bytes[y * 500 + 6 * x + 3 + k] == packed.rgb[3 * (64 * y + x) + k];
        same = same && bytes[y * 500 + 6 * x + k] == 7;
      }
    }
  }
  CHECK(same);

  std::fill(stage.visible.begin(), stage.visible.end(), std::uint8_t{0});
  const Image empty = draw(*egl, stage, 1, 64, 32);
  CHECK(std::all_of(empty.segment.begin(), empty.segment.end(), [](int x) { return x == 0; }));
  CHECK(std::all_of(empty.rgb.begin(), empty.rgb.end(), [](int x) { return x == 0; }));

  Image wide(65, 32);
  wide.rgb.assign(wide.rgb.size(), 9);
  const RenderImage images[] = {wide.image(0),
                                {17, 64, 32, wide.rgb.data(), 3, 192, nullptr, nullptr}};
  egl->render(0, stage.rows(), images);
  CHECK(std::all_of(wide.rgb.begin(), wide.rgb.end(), [](int x) { return x == 9; }));
}

TEST_CASE("OpenGL has depth and segments as observations have them", "[render][egl][depth]") {
  if (!has_egl()) return;
  const Stage stage = random_stage(2, false);
  const auto egl = make_egl_renderer(stage.scene, {}, 1);
  Image plain(48, 32);
  RenderImage image = plain.image(1);
  std::vector<std::int16_t> depth(2 * 48 * 32, 77);
  std::vector<std::int16_t> segment(depth);
  image.depth_mm = depth.data() + 1;
  image.segment_id = segment.data() + 1;
  image.cell_step = 2;
  image.cell_row = 96;
  egl->render(0, stage.rows(), {&image, 1});
  for (std::size_t i = 0; i < plain.depth.size(); ++i) {
    REQUIRE(segment[2 * i + 1] == plain.segment[i]);
    REQUIRE(depth[2 * i + 1] == std::min(std::lrint(1000 * plain.depth[i]), 32767L));
    REQUIRE(depth[2 * i] == 77);
    REQUIRE(segment[2 * i] == 77);
  }
  CHECK(*std::max_element(depth.begin(), depth.end()) > 500);
}

TEST_CASE("OpenGL workers draw the same on any thread", "[render][egl]") {
  if (!has_egl()) return;
  const Stage stage = random_stage(6, true);
  constexpr int kWorkers = 3;
  const auto egl = make_egl_renderer(stage.scene, {}, kWorkers);
  const Image wanted = draw(*egl, stage, 0, 96, 96);
  // Each round gives every worker to a new thread.
  for (int round = 0; round < 3; ++round) {
    std::vector<Image> images(kWorkers, Image(96, 96));
    std::vector<std::thread> threads;
    for (int worker = 0; worker < kWorkers; ++worker) {
      threads.emplace_back([&, worker] {
        for (int i = 0; i < 5; ++i) {
          const RenderImage image = images[static_cast<std::size_t>(worker)].image(0);
          egl->render(worker, stage.rows(), {&image, 1});
        }
      });
    }
    for (std::thread& thread : threads) thread.join();
    for (const Image& image : images) {
      CHECK(image.rgb == wanted.rgb);
      CHECK(image.depth == wanted.depth);
      CHECK(image.segment == wanted.segment);
    }
  }
}

TEST_CASE("The OpenGL renderer refuses what makes no sense", "[render][egl]") {
  const Stage stage = random_stage(1, false);
  const auto refused = [](const RenderScene& scene, const EglRendererOptions& options,
                          int workers) {
    try {
      make_egl_renderer(scene, options, workers);
    } catch (const Error& error) {
      return error.kind() == Error::kInvalidArgument;
    }
    return false;
  };
  EglRendererOptions options{.samples = 3};
  CHECK(refused(stage.scene, options, 1));
  options = {};
  options.max_width = 0;
  CHECK(refused(stage.scene, options, 1));
  options = {};
  options.tolerance = std::nanf("");
  CHECK(refused(stage.scene, options, 1));
  CHECK(refused(stage.scene, {}, 0));

  RenderScene scene = stage.scene;
  scene.geoms[0].size[0] = 0;
  CHECK(refused(scene, {}, 1));
  scene = stage.scene;
  scene.geoms[5].mesh = 1;
  CHECK(refused(scene, {}, 1));
  scene = stage.scene;
  scene.cameras[0].fovy = 4;
  CHECK(refused(scene, {}, 1));
  scene = stage.scene;
  scene.meshes[0].triangles[0] = 6;
  CHECK(refused(scene, {}, 1));
  scene = stage.scene;
  scene.lights.resize(9);
  CHECK(refused(scene, {}, 1));
}

}  // namespace engram
