#include "core/image/image_source.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/image/scene_from_model.h"
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

  // Bodies without a BodyView stay where the document has them, and as they are.
  bool is_still(int body) const {
    return std::find(bodies.begin(), bodies.end(), static_cast<std::size_t>(body)) == bodies.end();
  }
  void mark_still() {
    for (std::size_t i = 0; i < model.scene.geoms.size(); ++i) {
      model.scene.geoms[i].still = is_still(model.geom_body[i]);
    }
    for (std::size_t i = 0; i < model.scene.cameras.size(); ++i) {
      model.scene.cameras[i].still = is_still(model.camera_body[i]);
    }
  }
};

// Memory of one thread: an environment's rows, filled anew for every picture.
struct ImageSource::Workspace {
  Workspace(const ModelScene& scene, std::vector<Frame> initial)
      : frames(std::move(initial)),
        view_of_body(frames.size(), nullptr),
        geom_pose(12 * scene.scene.geoms.size()),
        rgba(scene.rgba),
        emission(scene.emission),
        visible(scene.scene.geoms.size(), 1),
        camera_pose(12 * scene.scene.cameras.size()) {}

  // Visibility and colours of one environment.
  void set_appearance(const ModelScene& scene) {
    for (std::size_t geom = 0; geom < scene.geom_body.size(); ++geom) {
      const BodyView* view = view_of_body[static_cast<std::size_t>(scene.geom_body[geom])];
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
};

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
    scene->bodies.push_back(static_cast<std::size_t>(body));
  }
  scene->mark_still();
  segments_ = name_segments(*model, scene->model);
  workspaces_.assign(static_cast<std::size_t>(workers),
                     Workspace(scene->model, initial_frames(*model)));
  renderer_ = make_renderer(drawn, options, workers);
  scene_ = std::move(scene);
}

ImageSource::~ImageSource() = default;

void ImageSource::render(int worker, std::span<const BodyView> bodies,
                         std::span<const RenderImage> images) {
  Workspace& workspace = workspaces_[static_cast<std::size_t>(worker)];
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    workspace.frames[scene_->bodies[i]] = bodies[i].frame;
    workspace.view_of_body[scene_->bodies[i]] = &bodies[i];
  }
  workspace.set_appearance(scene_->model);
  pose_geoms(scene_->model, workspace.frames.data(), workspace.geom_pose.data(),
             workspace.visible.data());
  pose_cameras(scene_->model, workspace.frames.data(), workspace.camera_pose.data());
  renderer_->render(worker,
                    {workspace.geom_pose.data(), workspace.rgba.data(), workspace.emission.data(),
                     workspace.visible.data(), workspace.camera_pose.data()},
                    images);
}

}  // namespace engram
