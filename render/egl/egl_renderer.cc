#include "render/egl/egl_renderer.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "render/egl/context.h"
#include "render/egl/painter.h"

namespace engram {
namespace {

[[noreturn]] void refuse(const std::string& message) {
  throw Error(Error::kInvalidArgument, "egl renderer: " + message);
}

void check_geom(const RenderScene& scene, std::size_t index) {
  const RenderGeom& geom = scene.geoms[index];
  const std::string name = "geom " + std::to_string(index);
  if (geom.shape > RenderShape::kMesh) {
    refuse(name + " has unknown shape " + std::to_string(static_cast<int>(geom.shape)));
  }
  const auto meshes = static_cast<int>(scene.meshes.size());
  if (geom.shape == RenderShape::kMesh) {
    if (geom.mesh < 0 || geom.mesh >= meshes) {
      refuse(name + " uses mesh " + std::to_string(geom.mesh) + " of " + std::to_string(meshes));
    }
    return;
  }
  const bool plane = geom.shape == RenderShape::kPlane;
  const bool round = geom.shape == RenderShape::kCapsule || geom.shape == RenderShape::kCylinder;
  const int count = geom.shape == RenderShape::kSphere ? 1 : (plane || round ? 2 : 3);
  for (int i = 0; i < count; ++i) {
    const float size = geom.size[i];
    if (!std::isfinite(size) || size < 0 || (size == 0 && !plane)) {
      refuse(name + " has size " + std::to_string(size) + "; must be finite and above 0");
    }
  }
}

void check_mesh(const RenderMesh& mesh, std::size_t index) {
  const std::string name = "mesh " + std::to_string(index);
  if (mesh.vertices.size() % 3 != 0 || mesh.triangles.size() % 3 != 0 || mesh.triangles.empty()) {
    refuse(name + " needs triangles and vertices of 3 numbers each");
  }
  const auto points = static_cast<std::int32_t>(mesh.vertices.size() / 3);
  for (const std::int32_t vertex : mesh.triangles) {
    if (vertex < 0 || vertex >= points) {
      refuse(name + " has a triangle of vertex " + std::to_string(vertex) + " of " +
             std::to_string(points));
    }
  }
  for (const float x : mesh.vertices) {
    if (!std::isfinite(x)) refuse(name + " has a vertex that is not finite");
  }
}

void check_scene(const RenderScene& scene) {
  for (std::size_t i = 0; i < scene.geoms.size(); ++i) check_geom(scene, i);
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) check_mesh(scene.meshes[i], i);
  for (const RenderCamera& camera : scene.cameras) {
    if (!(camera.fovy > 0 && camera.fovy < std::numbers::pi_v<float>)) {
      refuse("camera '" + camera.name + "' has fovy " + std::to_string(camera.fovy) +
             "; must be in (0, pi) rad");
    }
    if (!(camera.near_clip > 0 && camera.far_clip > camera.near_clip &&
          std::isfinite(camera.far_clip))) {
      refuse("camera '" + camera.name + "' needs 0 < near < far, finite");
    }
  }
  if (scene.lights.size() > gl::kMaxLights) {
    refuse(std::to_string(scene.lights.size()) + " lights; at most " +
           std::to_string(gl::kMaxLights));
  }
  for (const RenderLight& light : scene.lights) {
    const float length = std::hypot(light.direction[0], light.direction[1], light.direction[2]);
    if (!(length > 1e-6F && std::isfinite(length))) {
      refuse("a light needs a finite direction other than 0");
    }
  }
}

void check_options(const EglRendererOptions& options, int workers) {
  const int samples = options.samples;
  if (samples != 1 && samples != 2 && samples != 4 && samples != 8) {
    refuse(std::to_string(samples) + " samples; allowed are 1, 2, 4 and 8");
  }
  constexpr int kMaxPixels = 8192;
  const auto check = [](const char* what, int value, int least) {
    if (value < least || value > kMaxPixels) {
      refuse(std::string(what) + " " + std::to_string(value) + "; allowed are " +
             std::to_string(least) + " to " + std::to_string(kMaxPixels));
    }
  };
  check("max_width", options.max_width, 1);
  check("max_height", options.max_height, 1);
  check("shadow_map_size", options.shadow_map_size, 16);
  if (!(options.shadow_softness >= 0 && options.shadow_softness <= 0.5F)) {
    refuse("shadow_softness " + std::to_string(options.shadow_softness) +
           "; allowed are 0 to 0.5 rad");
  }
  if (!(options.tolerance >= 0.001F && options.tolerance <= 100)) {
    refuse("tolerance " + std::to_string(options.tolerance) + "; allowed are 0.001 to 100 pixels");
  }
  if (workers < 1) refuse(std::to_string(workers) + " workers; at least 1");
}

class EglRenderer final : public Renderer {
 public:
  EglRenderer(const RenderScene& scene, const EglRendererOptions& options, int workers)
      : scene_(scene), shapes_(scene_.meshes) {
    for (int i = 0; i < workers; ++i) {
      auto workspace = std::make_unique<Workspace>();
      const EglContext::Current current(workspace->context);
      if (!current.ok()) throw Error(Error::kUnavailable, "egl renderer: EGL lost its context");
      workspace->painter =
          std::make_unique<gl::GlPainter>(workspace->context.gl(), scene_, shapes_, options);
      workspaces_.push_back(std::move(workspace));
    }
  }

  const char* name() const override { return "egl"; }

  void render(int worker, const RenderInstances& instances,
              std::span<const RenderImage> images) override {
    Workspace& workspace = *workspaces_[static_cast<std::size_t>(worker)];
    const EglContext::Current current(workspace.context);
    if (current.ok()) workspace.painter->paint(instances, images);
  }

 private:
  // Working memory of one thread.
  struct Workspace {
    EglContext context{GlProfile::kCore};
    std::unique_ptr<gl::GlPainter> painter;
  };

  RenderScene scene_;
  gl::Shapes shapes_;
  std::vector<std::unique_ptr<Workspace>> workspaces_;
};

}  // namespace

std::unique_ptr<Renderer> make_egl_renderer(const RenderScene& scene,
                                            const EglRendererOptions& options, int workers) {
  check_options(options, workers);
  check_scene(scene);
  return std::make_unique<EglRenderer>(scene, options, workers);
}

}  // namespace engram
