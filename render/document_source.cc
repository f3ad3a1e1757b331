#include "render/document_source.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/scene/mujoco_handle.h"
#include "render/egl_renderer.h"
#include "render/scene_from_model.h"

namespace engram {
namespace {

constexpr int kShadowRays = 8;
constexpr int kEglSamples = 4;
constexpr std::size_t kPoseSize = 7;

std::unique_ptr<Renderer> make_renderer(const RenderScene& scene, const ImageSourceOptions& options,
                                        int workers, InstructionSet set) {
  if (options.renderer == "cpu") {
    CpuRendererOptions cpu;
    cpu.instruction_set = set;
    cpu.shadow_rays = options.shadows ? kShadowRays : 0;
    cpu.antialias = options.antialias;
    cpu.max_width = options.max_size;
    cpu.max_height = options.max_size;
    return make_cpu_renderer(scene, cpu, workers);
  }
  if (options.renderer == "egl") {
    EglRendererOptions egl;
    egl.shadows = options.shadows;
    egl.samples = options.antialias ? kEglSamples : 1;
    egl.max_width = options.max_size;
    egl.max_height = options.max_size;
    return make_egl_renderer(scene, egl, workers);
  }
  throw Error(Error::kInvalidArgument,
              "renderer '" + options.renderer + "' given, 'cpu' or 'egl' allowed");
}

class DocumentSource final : public ImageSource {
 public:
  DocumentSource(const std::string& document, const std::vector<std::string>& bodies,
                 const ImageSourceOptions& options, int workers, InstructionSet set) {
    const ModelPtr model = compile_model(document);
    scene_ = scene_from_model(*model, options.for_people);
    // The first light is slanted. The shadows of the one from above would be hidden under things.
    if (options.shadows && !scene_.scene.lights.empty()) {
      scene_.scene.lights.front().casts_shadow = true;
    }
    for (const RenderCamera& camera : scene_.scene.cameras) cameras_.push_back(camera.name);
    for (const std::string& name : bodies) {
      const int body = mj_name2id(model.get(), mjOBJ_BODY, name.c_str());
      if (body < 0) throw Error(Error::kInternal, "document without a body '" + name + "'");
      bodies_.push_back(static_cast<std::size_t>(body));
    }
    mark_still();
    name_segments(*model);
    prepare_workbenches(*model, workers);
    renderer_ = make_renderer(scene_.scene, options, workers, set);
  }

  const std::vector<std::string>& cameras() const override { return cameras_; }
  const std::vector<std::string>& segments() const override { return segments_; }

  void render(int worker, std::span<const BodyView> bodies,
              std::span<const RenderImage> images) override {
    Workspace& workspace = workbenches_[static_cast<std::size_t>(worker)];
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      double* pose = workspace.poses.data() + kPoseSize * bodies_[i];
      std::copy_n(bodies[i].pos, 3, pose);
      std::copy_n(bodies[i].quat, 4, pose + 3);
      workspace.view_of_body[bodies_[i]] = &bodies[i];
    }
    const BodyPoses<double> poses{workspace.poses.data(), kPoseSize, workspace.poses.data() + 3,
                                  kPoseSize};
    dress_geoms(workspace);
    pose_geoms(scene_, poses, workspace.geom_pose.data(), workspace.visible.data());
    pose_cameras(scene_, poses, workspace.camera_pose.data());
    renderer_->render(worker,
                      {workspace.geom_pose.data(), workspace.rgba.data(), workspace.emission.data(),
                       workspace.visible.data(), workspace.camera_pose.data()},
                      images);
  }

 private:
  // Working memory of one thread: an environment's rows, filled anew for every picture.
  struct Workspace {
    std::vector<double> poses;                  // (bodies of the model, 7)
    std::vector<const BodyView*> view_of_body;  // or null
    std::vector<float> geom_pose;
    std::vector<float> rgba;
    std::vector<float> emission;
    std::vector<std::uint8_t> visible;
    std::vector<float> camera_pose;
  };

  // Bodies that are not in `bodies_` stay where the document has them, and as they are.
  bool is_still(int body) const {
    const auto index = static_cast<std::size_t>(body);
    return std::find(bodies_.begin(), bodies_.end(), index) == bodies_.end();
  }
  void mark_still() {
    for (std::size_t i = 0; i < scene_.scene.geoms.size(); ++i) {
      scene_.scene.geoms[i].still = is_still(scene_.geom_body[i]);
    }
    for (std::size_t i = 0; i < scene_.scene.cameras.size(); ++i) {
      scene_.scene.cameras[i].still = is_still(scene_.camera_body[i]);
    }
  }

  // One for each body in the document's order; what belongs to none goes by its own name.
  void name_segments(const mjModel& model) {
    segments_ = {"background"};
    for (std::size_t i = 0; i < scene_.geom_body.size(); ++i) {
      const int body = scene_.geom_body[i];
      const std::string name = model.names + (body == 0 ? model.name_geomadr[scene_.model_geom[i]]
                                                        : model.name_bodyadr[body]);
      const auto found = std::find(segments_.begin(), segments_.end(), name);
      scene_.scene.geoms[i].segment = static_cast<std::int32_t>(found - segments_.begin());
      if (found == segments_.end()) segments_.push_back(name);
    }
  }

  void prepare_workbenches(const mjModel& model, int workers) {
    const DataPtr data = make_data(model);
    mj_kinematics(&model, data.get());
    Workspace workspace;
    std::vector<double>& poses = workspace.poses;
    for (int body = 0; body < model.nbody; ++body) {
      poses.insert(poses.end(), data->xpos + 3 * body, data->xpos + 3 * body + 3);
      poses.insert(poses.end(), data->xquat + 4 * body, data->xquat + 4 * body + 4);
    }
    workspace.view_of_body.assign(static_cast<std::size_t>(model.nbody), nullptr);
    workspace.geom_pose.resize(12 * scene_.scene.geoms.size());
    workspace.rgba = scene_.rgba;
    workspace.emission = scene_.emission;
    workspace.visible.assign(scene_.scene.geoms.size(), 1);
    workspace.camera_pose.resize(12 * scene_.scene.cameras.size());
    workbenches_.assign(static_cast<std::size_t>(workers), workspace);
  }

  // Visibility and colours of one environment.
  void dress_geoms(Workspace& workspace) const {
    for (std::size_t geom = 0; geom < scene_.geom_body.size(); ++geom) {
      const BodyView* view =
          workspace.view_of_body[static_cast<std::size_t>(scene_.geom_body[geom])];
      if (view == nullptr) continue;
      workspace.visible[geom] = view->visible ? 1 : 0;
      const bool painted = view->rgba[3] > 0;
      std::copy_n(painted ? view->rgba : scene_.rgba.data() + 4 * geom, 4,
                  workspace.rgba.data() + 4 * geom);
      workspace.emission[geom] = scene_.emission[geom] + view->emission;
    }
  }

  ModelScene scene_;
  std::vector<std::string> cameras_;
  std::vector<std::string> segments_;
  std::vector<std::size_t> bodies_;  // the model's body of each BodyView
  std::vector<Workspace> workbenches_;
  std::unique_ptr<Renderer> renderer_;
};

}  // namespace

std::unique_ptr<ImageSource> make_document_source(const std::string& document,
                                                  const std::vector<std::string>& bodies,
                                                  const ImageSourceOptions& options, int workers) {
  return make_document_source_on(InstructionSet::kAuto, document, bodies, options, workers);
}

std::unique_ptr<ImageSource> make_document_source_on(InstructionSet set,
                                                     const std::string& document,
                                                     const std::vector<std::string>& bodies,
                                                     const ImageSourceOptions& options,
                                                     int workers) {
  return std::make_unique<DocumentSource>(document, bodies, options, workers, set);
}

}  // namespace engram
