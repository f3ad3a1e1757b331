#include "core/image/image_source.h"

#include <algorithm>
#include <array>

#include "core/base/error.h"
#include "core/base/index.h"
#include "core/image/scene_extras.h"
#include "core/image/scene_from_model.h"
#include "core/math/real_functions.h"
#include "core/scene/mujoco_handle.h"

namespace engram {
namespace {

// Names of segments, one for each body in the document's order; what belongs to none goes by its
// own name. Numbers the geoms by them.
std::vector<std::string> name_segments(const mjModel& model, ModelScene& scene) {
  std::vector<std::string> segments = {"background"};
  for (std::size_t i = 0; i < scene.geom_body.size(); ++i) {
    const int body = scene.geom_body[i];
    const std::string name = model.names + (body == 0 ? model.name_geomadr[scene.model_geom[i]]
                                                      : model.name_bodyadr[body]);
    const auto found = std::find(segments.begin(), segments.end(), name);
    scene.scene.geoms[i].segment = static_cast<std::int32_t>(found - segments.begin());
    if (found == segments.end()) segments.push_back(name);
  }
  return segments;
}

// Frames of all bodies as the document has them.
std::vector<Frame> initial_frames(const mjModel& model) {
  const DataPtr data = make_data(model);
  mj_kinematics(&model, data.get());
  std::vector<Frame> frames;
  for (int body = 0; body < model.nbody; ++body) {
    frames.push_back(make_frame(data->xpos + 3 * body, data->xquat + 4 * body));
  }
  return frames;
}

}  // namespace

struct ImageSource::Scene {
  ModelScene model;
  std::vector<std::size_t> bodies;  // the model's body of each BodyView

  // Set where a source varies.
  bool varies = false;
  SceneExtras extras;
  std::vector<std::size_t> sensors;  // the model's cameras of kSensorCameraNames
  std::size_t table = 0;             // the geoms of the surfaces that change
  std::size_t ground = 0;

  void add_changes(const mjModel& from, std::vector<std::string>& segments);

  // Bodies without a BodyView stay where the document has them, and as they are.
  bool is_still(int body) const {
    return std::find(bodies.begin(), bodies.end(), at(body)) == bodies.end();
  }
  void mark_still() {
    for (std::size_t i = 0; i < model.geom_body.size(); ++i) {
      model.scene.geoms[i].still = !varies && is_still(model.geom_body[i]);
    }
    for (std::size_t i = 0; i < model.scene.cameras.size(); ++i) {
      model.scene.cameras[i].still = !varies && is_still(model.camera_body[i]);
    }
  }
};

// Memory of one thread: an environment's rows, filled anew for every image.
struct ImageSource::Workspace {
  Workspace(const ModelScene& scene, std::vector<Frame> initial)
      : frames(std::move(initial)),
        view_of_body(frames.size(), nullptr),
        geom_pose(12 * scene.scene.geoms.size()),
        rgba(scene.rgba),
        emission(scene.emission),
        visible(scene.scene.geoms.size(), 1),
        camera_pose(12 * scene.scene.cameras.size()) {
    rgba.resize(4 * visible.size());
    emission.resize(visible.size());
    for (const RenderCamera& camera : scene.scene.cameras) fovy.push_back(camera.fovy);
    for (const RenderGeom& geom : scene.scene.geoms) surface.push_back({geom.pattern});
    lighting.lights = scene.scene.lights;
  }

  void apply(const Scene& scene, const ImageChanges& changes);
  void apply_cameras(const Scene& scene, const ImageChanges& changes);
  void apply_lights(const RenderScene& scene, const LightChange& change);
  void apply_surface(const Scene& scene, std::size_t geom, const SurfaceChange& change);

  // Visibility and colours of one environment.
  void set_appearance(const ModelScene& scene) {
    for (std::size_t geom = 0; geom < scene.geom_body.size(); ++geom) {
      const BodyView* view = view_of_body[at(scene.geom_body[geom])];
      if (view == nullptr) continue;
      visible[geom] = view->visible ? 1 : 0;
      const bool painted = view->rgba[3] > 0;
      std::copy_n(painted ? view->rgba : scene.rgba.data() + 4 * geom, 4, rgba.data() + 4 * geom);
      emission[geom] = scene.emission[geom] + view->emission;
    }
  }

  std::vector<Frame> frames;                  // of the model's bodies
  std::vector<const BodyView*> view_of_body;  // or null
  std::vector<float> geom_pose;
  std::vector<float> rgba;
  std::vector<float> emission;
  std::vector<std::uint8_t> visible;
  std::vector<float> camera_pose;
  std::vector<float> fovy;
  std::vector<RenderSurface> surface;
  RenderLighting lighting;
};

// Distractors and post come last, so that all else has the same numbers.
void ImageSource::Scene::add_changes(const mjModel& from, std::vector<std::string>& segments) {
  varies = true;
  const auto require = [](bool found, const std::string& name) {
    if (!found) throw Error(Error::kInternal, "document without '" + name + "', which changes");
  };
  const auto geom_of = [&](const char* name) {
    const auto found = std::ranges::find(model.model_geom, mj_name2id(&from, mjOBJ_GEOM, name));
    require(found != model.model_geom.end(), name);
    return static_cast<std::size_t>(found - model.model_geom.begin());
  };
  table = geom_of("table");
  ground = geom_of("ground");
  for (const char* name : kSensorCameraNames) {
    const auto found = std::ranges::find(model.scene.cameras, name, &RenderCamera::name);
    require(found != model.scene.cameras.end(), name);
    sensors.push_back(static_cast<std::size_t>(found - model.scene.cameras.begin()));
  }
  extras = SceneExtras(model.scene, segments);
}

void ImageSource::Workspace::apply(const Scene& scene, const ImageChanges& changes) {
  if (changes.cameras) apply_cameras(scene, changes);
  if (changes.lights) apply_lights(scene.model.scene, changes.light);
  if (changes.table) apply_surface(scene, scene.table, changes.table_surface);
  if (changes.ground) apply_surface(scene, scene.ground, changes.ground_surface);
  scene.extras.place(changes, geom_pose.data(), rgba.data(), visible.data());
}

void ImageSource::Workspace::apply_cameras(const Scene& scene, const ImageChanges& changes) {
  for (std::size_t i = 0; i < scene.sensors.size(); ++i) {
    const std::size_t camera = scene.sensors[i];
    float* pose = camera_pose.data() + 12 * camera;
    using Rows = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;
    Eigen::Map<Rows> axes(pose);
    Eigen::Map<Eigen::Matrix<float, 3, 1>> position(pose + 9);
    const Frame frame = moved({position.cast<double>(), axes.cast<double>()}, changes.camera[i]);
    axes = frame.axes.cast<float>();
    position = frame.pos.cast<float>();
    fovy[camera] =
        scene.model.scene.cameras[camera].fovy + static_cast<float>(changes.camera[i].fovy);
  }
}

void ImageSource::Workspace::apply_lights(const RenderScene& scene, const LightChange& change) {
  std::array<float, 3> factor = {};
  for (std::size_t k = 0; k < 3; ++k) {
    factor[k] = static_cast<float>((1 + change.brightness) * (1 + change.color[k]));
    lighting.ambient[k] = scene.ambient[k] * factor[k];
  }
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const RenderLight& from = scene.lights[i];
    RenderLight& to = lighting.lights[i];
    for (std::size_t k = 0; k < 3; ++k) to.color[k] = from.color[k] * factor[k];
    const auto x = static_cast<double>(from.direction[0]);
    const auto y = static_cast<double>(from.direction[1]);
    const double level = real::hypot(x, y);
    if (level < 1e-6) continue;  // a light from above stays there
    const double azimuth = real::atan2(y, x) + change.azimuth;
    const double elevation =
        real::atan2(-static_cast<double>(from.direction[2]), level) + change.elevation;
    to.direction[0] = static_cast<float>(real::cos(elevation) * real::cos(azimuth));
    to.direction[1] = static_cast<float>(real::cos(elevation) * real::sin(azimuth));
    to.direction[2] = static_cast<float>(-real::sin(elevation));
  }
}

void ImageSource::Workspace::apply_surface(const Scene& scene, std::size_t geom,
                                           const SurfaceChange& change) {
  surface[geom] = change.surface;
  for (std::size_t k = 0; k < 3; ++k) {
    rgba[4 * geom + k] = std::min(1.0F, scene.model.rgba[4 * geom + k] * (1 + change.color[k]));
  }
}

ImageSource::ImageSource(const std::string& document, const std::vector<std::string>& bodies,
                         const ImageSourceOptions& options, int workers,
                         const RendererFactory& make_renderer) {
  const ModelPtr model = compile_model(document);
  auto scene = std::make_unique<Scene>();
  scene->model = scene_from_model(*model, options.for_people);
  RenderScene& drawn = scene->model.scene;
  // The first light is slanted. The shadows of the one from above would be hidden under things.
  if (options.shadows && !drawn.lights.empty()) drawn.lights.front().casts_shadow = true;
  for (const RenderCamera& camera : drawn.cameras) cameras_.push_back(camera.name);
  for (const std::string& name : bodies) {
    const int body = mj_name2id(model.get(), mjOBJ_BODY, name.c_str());
    if (body < 0) throw Error(Error::kInternal, "document without a body '" + name + "'");
    scene->bodies.push_back(at(body));
  }
  segments_ = name_segments(*model, scene->model);
  if (options.varies) scene->add_changes(*model, segments_);
  scene->mark_still();
  workspaces_.assign(at(workers), Workspace(scene->model, initial_frames(*model)));
  renderer_ = make_renderer(drawn, options, workers);
  scene_ = std::move(scene);
}

ImageSource::~ImageSource() = default;

void ImageSource::render(int worker, std::span<const BodyView> bodies,
                         std::span<const RenderImage> images, const ImageChanges* changes) {
  Workspace& workspace = workspaces_[at(worker)];
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    workspace.frames[scene_->bodies[i]] = bodies[i].frame;
    workspace.view_of_body[scene_->bodies[i]] = &bodies[i];
  }
  workspace.set_appearance(scene_->model);
  pose_geoms(scene_->model, workspace.frames.data(), workspace.geom_pose.data(),
             workspace.visible.data());
  pose_cameras(scene_->model, workspace.frames.data(), workspace.camera_pose.data());
  RenderInstances rows{workspace.geom_pose.data(), workspace.rgba.data(), workspace.emission.data(),
                       workspace.visible.data(), workspace.camera_pose.data()};
  if (changes != nullptr && scene_->varies) {
    workspace.apply(*scene_, *changes);
    rows.camera_fovy = workspace.fovy.data();
    if (changes->lights) rows.lighting = &workspace.lighting;
    rows.geom_surface = workspace.surface.data();
  }
  renderer_->render(worker, rows, images);
}

}  // namespace engram
