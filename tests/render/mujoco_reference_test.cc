// The renderers against MuJoCo's own, on the engine's documents.
#include "render/mujoco_reference.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/image/scene_from_model.h"
#include "core/scene/mujoco_handle.h"
#include "core/task/task.h"
#include "render/cpu/cpu_renderer.h"
#include "render/egl/context.h"
#include "render/egl/egl_renderer.h"
#include "tasks/registry.h"
#include "tests/render/has_egl.h"

namespace engram {
namespace {

// Fine enough that its polygons do not show at these sizes.
MujocoReferenceOptions fine() {
  MujocoReferenceOptions options;
  options.slices = 128;
  options.stacks = 64;
  options.plain = true;
  return options;
}

// A task's document in changing states, drawn by either side.
class Comparison {
 public:
  Comparison()
      : model_(compile_model(make_task("RememberColor9-VLA-v0")->document())),
        data_(make_data(*model_)),
        scene_(scene_from_model(*model_)) {
    // Patterns are made differently, so they are compared elsewhere.
    for (RenderGeom& geom : scene_.scene.geoms) geom.pattern = RenderPattern::kPlain;
    for (std::size_t i = 0; i < scene_.model_geom.size(); ++i) untextured_color(i);
    visible_.assign(scene_.scene.geoms.size(), 1);
    geom_pose_.resize(12 * scene_.scene.geoms.size());
    camera_pose_.resize(12 * scene_.scene.cameras.size());
    mj_resetDataKeyframe(model_.get(), data_.get(), 0);
    start_.assign(data_->qpos, data_->qpos + model_->nq);
  }

  const mjModel& model() const { return *model_; }
  mjData& data() { return *data_; }
  const RenderScene& scene() const { return scene_.scene; }

  // The arm somewhere about its start pose, free props somewhere on or above the table.
  void shuffle(unsigned seed) {
    std::mt19937 random(seed);
    const auto uniform = [&random](double low, double high) {
      return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
    };
    std::copy(start_.begin(), start_.end(), data_->qpos);
    for (int joint = 0; joint < model_->njnt; ++joint) {
      double* q = data_->qpos + model_->jnt_qposadr[joint];
      if (model_->jnt_type[joint] == mjJNT_FREE) {
        q[0] = uniform(-0.3, 0.15);
        q[1] = uniform(-0.3, 0.3);
        q[2] = uniform(0.02, 0.12);
        for (int k = 3; k < 7; ++k) q[k] = uniform(-1, 1);
        mju_normalize4(q + 3);
      } else if (model_->jnt_type[joint] == mjJNT_HINGE) {
        *q += uniform(-0.3, 0.3);
      } else {
        *q = uniform(model_->jnt_range[2 * joint], model_->jnt_range[2 * joint + 1]);
      }
    }
    // Mocap bodies as well.
    for (int i = 0; i < model_->nmocap; ++i) {
      data_->mocap_pos[3 * i] = uniform(-0.3, 0.15);
      data_->mocap_pos[3 * i + 1] = uniform(-0.3, 0.3);
      data_->mocap_pos[3 * i + 2] = uniform(0.02, 0.12);
    }
    mj_kinematics(model_.get(), data_.get());
    mj_comPos(model_.get(), data_.get());
    mj_camlight(model_.get(), data_.get());
    std::vector<Frame> bodies;
    for (int body = 0; body < model_->nbody; ++body) {
      bodies.push_back(make_frame(data_->xpos + 3 * body, data_->xquat + 4 * body));
    }
    pose_geoms(scene_, bodies.data(), geom_pose_.data());
    pose_cameras(scene_, bodies.data(), camera_pose_.data());
  }

  RenderInstances rows() const {
    return {geom_pose_.data(), scene_.rgba.data(), scene_.emission.data(), visible_.data(),
            camera_pose_.data()};
  }

 private:
  // As MuJoCo has it without the texture.
  void untextured_color(std::size_t index) {
    const int geom = scene_.model_geom[index];
    const int material = model_->geom_matid[geom];
    if (material < 0 || model_->mat_texid[material] < 0) return;
    std::copy_n(model_->mat_rgba + 4 * material, 4, scene_.rgba.data() + 4 * index);
  }

  ModelPtr model_;
  DataPtr data_;
  ModelScene scene_;
  std::vector<double> start_;
  std::vector<std::uint8_t> visible_;
  std::vector<float> geom_pose_, camera_pose_;
};

struct Image {
  explicit Image(int size_in)
      : size(size_in), pixels(static_cast<std::size_t>(size) * static_cast<std::size_t>(size)) {
    rgb.resize(3 * pixels);
    depth.resize(pixels);
    segment.resize(pixels);
  }
  int size;
  std::size_t pixels;
  std::vector<std::uint8_t> rgb;
  std::vector<float> depth;
  std::vector<std::int32_t> segment;
};

struct Difference {
  double color = 0;       // mean absolute, of 255
  double worst = 0;       // the same of the worst image
  double silhouette = 0;  // pixels of another geom
  double depth = 0;       // mean relative, where geoms agree
  int images = 0;
};

void accumulate(const Image& a, const Image& b, Difference& sum) {
  double color = 0;
  double silhouette = 0;
  double depth = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) color += std::abs(a.rgb[i] - b.rgb[i]);
  for (std::size_t i = 0; i < a.pixels; ++i) {
    if (a.segment[i] != b.segment[i]) {
      silhouette += 1;
    } else if (a.segment[i] != 0) {
      depth += std::abs(a.depth[i] / b.depth[i] - 1);
    }
  }
  color /= static_cast<double>(a.rgb.size());
  sum.color += color;
  sum.worst = std::max(sum.worst, color);
  sum.silhouette += silhouette / static_cast<double>(a.pixels);
  sum.depth += depth / static_cast<double>(a.pixels);
  ++sum.images;
}

constexpr int kSize = 128;
constexpr unsigned kStates = 24;

// MuJoCo's images of all cameras in all states.
std::vector<Image> reference_images(const MujocoReferenceOptions& options) {
  Comparison comparison;
  MujocoReference reference(comparison.model(), options);
  std::vector<Image> images;
  for (unsigned state = 0; state < kStates; ++state) {
    comparison.shuffle(state);
    for (const RenderCamera& camera : comparison.scene().cameras) {
      Image& image = images.emplace_back(kSize);
      reference.render(comparison.data(), camera.name, kSize, kSize, image.rgb.data(),
                       image.depth.data(), image.segment.data());
    }
  }
  return images;
}

// The finest polygons take software a second for six images.
const std::vector<Image>& fine_images() {
  static const std::vector<Image> images = reference_images(fine());
  return images;
}

Difference compare(Renderer& renderer, Comparison& comparison, const std::vector<Image>& images) {
  Difference sum;
  auto theirs = images.begin();
  for (unsigned state = 0; state < kStates; ++state) {
    comparison.shuffle(state);
    for (std::size_t camera = 0; camera < comparison.scene().cameras.size(); ++camera) {
      Image ours(kSize);
      const RenderImage image = {
          static_cast<int>(camera), kSize, kSize, ours.rgb.data(), 3, 3 * kSize, ours.depth.data(),
          ours.segment.data()};
      renderer.render(0, comparison.rows(), {&image, 1});
      accumulate(ours, *theirs++, sum);
    }
  }
  sum.color /= sum.images;
  sum.silhouette /= sum.images;
  sum.depth /= sum.images;
  return sum;
}

// The ray caster's from the finest polygons.
const Difference& of_ray_caster() {
  static const Difference difference = [] {
    Comparison comparison;
    return compare(*make_cpu_renderer(comparison.scene(), {}, 1), comparison, fine_images());
  }();
  return difference;
}

// MuJoCo 3 and newer draw the same shapes in other light than the original's.
constexpr bool kSameLight = mjVERSION_HEADER < 300;

void check(const Difference& difference) {
  CAPTURE(difference.color, difference.worst, difference.silhouette, difference.depth);
  CHECK(difference.images >= 64);
  if (kSameLight) CHECK(difference.color <= 0.5);
  CHECK(difference.silhouette <= 0.001);
  CHECK(difference.depth <= 1e-3);
}

}  // namespace

TEST_CASE("The ray caster agrees with MuJoCo's renderer", "[render][reference]") {
  if (!has_egl()) return;
  check(of_ray_caster());
}

TEST_CASE("The OpenGL renderer agrees with MuJoCo's", "[render][reference]") {
  if (!has_egl()) return;
  Comparison comparison;
  const EglRendererOptions options{.tolerance = 0.03F};
  const auto egl = make_egl_renderer(comparison.scene(), options, 1);
  check(compare(*egl, comparison, fine_images()));
}

TEST_CASE("What differs from MuJoCo's renderer is its tessellation", "[render][reference]") {
  if (!has_egl()) return;
  Comparison comparison;
  const auto cpu = make_cpu_renderer(comparison.scene(), {}, 1);
  MujocoReferenceOptions coarse = fine();
  coarse.slices = 12;
  coarse.stacks = 8;
  const Difference rough = compare(*cpu, comparison, reference_images(coarse));
  const Difference& smooth = of_ray_caster();
  CAPTURE(rough.color, smooth.color, rough.silhouette, smooth.silhouette);
  if (kSameLight) CHECK(rough.color > 3 * smooth.color);
  CHECK(rough.silhouette > 3 * smooth.silhouette);
}

TEST_CASE("The reference refuses unknown cameras and sizes", "[render][reference]") {
  if (!has_egl()) return;
  Comparison comparison;
  comparison.shuffle(0);
  MujocoReference reference(comparison.model(), {});
  std::vector<std::uint8_t> rgb(3 * 600 * 600);
  CHECK_THROWS_AS(reference.render(comparison.data(), "nobody", 64, 64, rgb.data()), Error);
  CHECK_THROWS_AS(reference.render(comparison.data(), "base_camera", 513, 64, rgb.data()), Error);
  CHECK_THROWS_AS(reference.render(comparison.data(), "base_camera", 64, 0, rgb.data()), Error);
  reference.render(comparison.data(), "base_camera", 512, 64, rgb.data());
}

}  // namespace engram
