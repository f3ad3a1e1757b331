#include "render/mujoco_reference.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <vector>

#include "core/base/error.h"
#include "core/scene/mujoco_handle.h"
#include "core/scene/mujoco_versions.h"
#include "render/egl/context.h"

namespace engram {
namespace {

// MuJoCo finds its OpenGL functions on the first mjr_makeContext, without a lock.
std::mutex& creation() {
  static std::mutex mutex;
  return mutex;
}

ModelPtr copy_model(const mjModel& model) {
  const MujocoScope scope;
  ModelPtr copy(mj_copyModel(nullptr, &model));
  if (copy == nullptr) throw Error(Error::kUnavailable, "mujoco reference: out of memory");
  return copy;
}

// Removes what RenderScene does not have.
void make_plain(mjModel& model) {
  std::fill_n(model.light_specular, 3 * model.nlight, 0.0F);
  std::fill_n(model.vis.headlight.specular, 3, 0.0F);
  std::fill_n(model.vis.headlight.diffuse, 3, 0.0F);
  std::fill_n(model.mat_specular, model.nmat, 0.0F);
  std::fill_n(model.mat_reflectance, model.nmat, 0.0F);
  for (int i = 0; i < model.nmat; ++i) texture_of(model, i) = -1;
}

// Turns rows upside down.
template <class T>
void flip(T* rows, int height, int row_size) {
  for (int y = 0; y < height / 2; ++y) {
    T* top = rows + static_cast<std::ptrdiff_t>(y) * row_size;
    T* bottom = rows + static_cast<std::ptrdiff_t>(height - 1 - y) * row_size;
    std::swap_ranges(top, top + row_size, bottom);
  }
}

}  // namespace

struct MujocoReference::Parts {
  explicit Parts(const mjModel& from) : model(copy_model(from)) {}
  ~Parts() {
    mjv_freeScene(&scene);
    if (!made) return;
    const EglContext::Current current(context);
    mjr_freeContext(&drawing);
  }

  EglContext context{GlProfile::kCompatibility};
  ModelPtr model;
  MujocoReferenceOptions options;
  mjrContext drawing = {};
  mjvScene scene = {};
  mjvOption shown = {};
  bool made = false;  // the drawing context
};

MujocoReference::MujocoReference(const mjModel& model, const MujocoReferenceOptions& options)
    : parts_(std::make_unique<Parts>(model)) {
  Parts& parts = *parts_;
  parts.options = options;
  mjModel& own = *parts.model;
  own.vis.global.offwidth = options.max_width;
  own.vis.global.offheight = options.max_height;
  own.vis.quality.numslices = options.slices;
  own.vis.quality.numstacks = options.stacks;
  own.vis.quality.numquads = options.quads;
  own.vis.quality.offsamples = options.samples;
  own.vis.quality.shadowsize = options.shadow_size;
  if (options.plain) make_plain(own);

  const MujocoScope scope;
  const EglContext::Current current(parts.context);
  const std::lock_guard lock(creation());
  mjv_defaultScene(&parts.scene);
  mjv_defaultOption(&parts.shown);
  mjr_defaultContext(&parts.drawing);
  mjv_makeScene(&own, &parts.scene, static_cast<int>(own.ngeom) + 100);
  parts.scene.flags[mjRND_SHADOW] = options.shadow_size > 0 ? 1 : 0;
  if (options.plain) parts.scene.flags[mjRND_REFLECTION] = 0;
  mjr_makeContext(&own, &parts.drawing, mjFONTSCALE_100);
  parts.made = true;
  mjr_setBuffer(mjFB_OFFSCREEN, &parts.drawing);
  if (parts.drawing.currentBuffer != mjFB_OFFSCREEN) {
    throw Error(Error::kUnavailable, "mujoco reference: no offscreen framebuffer");
  }
}

MujocoReference::~MujocoReference() = default;

mjModel& MujocoReference::model() { return *parts_->model; }

void MujocoReference::render(mjData& data, const std::string& camera, int width, int height,
                             std::uint8_t* rgb, float* depth, std::int32_t* segment) {
  Parts& parts = *parts_;
  const MujocoReferenceOptions& options = parts.options;
  if (width < 1 || height < 1 || width > options.max_width || height > options.max_height) {
    throw Error(Error::kInvalidArgument, "mujoco reference: size " + std::to_string(width) + " x " +
                                             std::to_string(height) + "; allowed are 1 x 1 to " +
                                             std::to_string(options.max_width) + " x " +
                                             std::to_string(options.max_height));
  }
  const mjModel& model = *parts.model;
  mjvCamera view;
  mjv_defaultCamera(&view);
  view.type = mjCAMERA_FIXED;
  view.fixedcamid = mj_name2id(&model, mjOBJ_CAMERA, camera.c_str());
  if (view.fixedcamid < 0) {
    throw Error(Error::kUnknownId, "mujoco reference: no camera '" + camera + "'");
  }

  const MujocoScope scope;
  const EglContext::Current current(parts.context);
  if (!current.ok()) throw Error(Error::kUnavailable, "mujoco reference: EGL lost its context");
  mjv_updateScene(&model, &data, &parts.shown, nullptr, &view, mjCAT_ALL, &parts.scene);
  const mjrRect viewport = {0, 0, width, height};
  mjr_render(viewport, &parts.scene, &parts.drawing);
  mjr_readPixels(rgb, depth, viewport, &parts.drawing);
  flip(rgb, height, 3 * width);
  if (segment != nullptr) read_segments(width, height, segment);
  if (depth == nullptr) return;

  flip(depth, height, width);
  const auto near = static_cast<float>(model.vis.map.znear * model.stat.extent);
  const auto far = static_cast<float>(model.vis.map.zfar * model.stat.extent);
  for (std::ptrdiff_t i = 0; i < static_cast<std::ptrdiff_t>(width) * height; ++i) {
    depth[i] = depth[i] >= 1 ? 0 : near * far / (far - depth[i] * (far - near));
  }
}

// Draws once more, with numbers for colours.
void MujocoReference::read_segments(int width, int height, std::int32_t* segment) {
  Parts& parts = *parts_;
  const mjrRect viewport = {0, 0, width, height};
  parts.scene.flags[mjRND_SEGMENT] = 1;
  parts.scene.flags[mjRND_IDCOLOR] = 1;
  mjr_render(viewport, &parts.scene, &parts.drawing);
  parts.scene.flags[mjRND_SEGMENT] = 0;
  parts.scene.flags[mjRND_IDCOLOR] = 0;

  std::vector<std::int32_t> geom_of(static_cast<std::size_t>(parts.scene.ngeom) + 1);
  for (int i = 0; i < parts.scene.ngeom; ++i) {
    const mjvGeom& geom = parts.scene.geoms[i];
    if (geom.segid < 0 || geom.objtype != mjOBJ_GEOM) continue;
    geom_of[static_cast<std::size_t>(geom.segid) + 1] = geom.objid + 1;
  }
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  std::vector<std::uint8_t> rgb(3 * pixels);
  mjr_readPixels(rgb.data(), nullptr, viewport, &parts.drawing);
  flip(rgb.data(), height, 3 * width);
  for (std::size_t i = 0; i < pixels; ++i) {
    const std::size_t id = rgb[3 * i] + 256U * rgb[3 * i + 1] + 65536U * rgb[3 * i + 2];
    segment[i] = id < geom_of.size() ? geom_of[id] : 0;
  }
}

}  // namespace engram
