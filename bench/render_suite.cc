#include "bench/render_suite.h"

#include <algorithm>

#include "bench/rollout.h"
#include "core/batch/queries.h"
#include "core/image/image_batch.h"
#include "render/make_renderer.h"
#include "render/mujoco_reference.h"

namespace engram::bench {
namespace {

constexpr int kCameras = 2;  // base and wrist, as in rgb observations
constexpr const char* kCameraNames[kCameras] = {"base_camera", "hand_camera"};

// Environments in the middle of their episodes, to be rendered repeatedly.
class RenderScenes {
 public:
  RenderScenes(const std::string& id, int num_envs)
      : rollout_(id, rollout_options(num_envs, 1), Policy::kOracle) {
    constexpr int kSteps = 12;
    rollout_.rate(kSteps);
  }

  Batch& batch() { return *rollout_.batch; }
  const State& state() { return rollout_.batch->state(); }

 private:
  Rollout rollout_;
};

// engram's renderer on one thread.
class CpuRenderLoop {
 public:
  CpuRenderLoop(RenderScenes& scenes, int size)
      : scenes_(scenes), views_(scenes.batch().physics_model(), 1) {
    ImageSourceOptions options;
    options.max_size = size;
    source_ = std::make_unique<ImageSource>(Queries(scenes.batch()).document(), views_.body_names(),
                                            options, 1, make_renderer);
    rgb_.resize(static_cast<std::size_t>(size * size * 3 * kCameras));
    for (int camera = 0; camera < kCameras; ++camera) {
      RenderImage image;
      image.camera = find_camera(*source_, kCameraNames[camera]);
      image.width = size;
      image.height = size;
      image.rgb = rgb_.data() + 3 * camera;
      image.pixel_stride = 3 * kCameras;
      image.row_stride = image.pixel_stride * size;
      images_.push_back(image);
    }
  }

  // Images per second over all environments, `rounds` times.
  double rate(int rounds) {
    const int n = scenes_.batch().num_envs();
    const double spent = seconds([&] {
      for (int round = 0; round < rounds; ++round) {
        for (int env = 0; env < n; ++env) {
          source_->render(0, views_.view(0, scenes_.state(), env), images_);
        }
      }
    });
    return rounds * n * kCameras / spent;
  }

 private:
  RenderScenes& scenes_;
  SceneViews views_;
  std::unique_ptr<ImageSource> source_;
  std::vector<std::uint8_t> rgb_;
  std::vector<RenderImage> images_;
};

// MuJoCo's renderer through EGL.
class MujocoRenderLoop {
 public:
  MujocoRenderLoop(RenderScenes& scenes, int size, MujocoReferenceOptions options)
      : scenes_(scenes),
        model_(compile_model(Queries(scenes.batch()).document())),
        data_(make_data(*model_)),
        size_(size),
        rgb_(static_cast<std::size_t>(size * size * 3)) {
    options.max_width = size;
    options.max_height = size;
    reference_ = std::make_unique<MujocoReference>(*model_, options);
  }

  double rate(int count) {
    double spent = 0;
    for (int env = 0; env < count; ++env) {
      pose(env % scenes_.batch().num_envs());
      spent += seconds([&] {
        for (const char* camera : kCameraNames) {
          reference_->render(*data_, camera, size_, size_, rgb_.data());
        }
      });
    }
    return count * kCameras / spent;
  }

 private:
  // Hidden props wait below the floor.
  void pose(int env) {
    const State& state = scenes_.state();
    std::copy_n(state.qpos.row(env), kRobotJoints, data_->qpos);
    for (int prop = 0; prop < state.num_props; ++prop) {
      const std::string& name =
          scenes_.batch().physics_model().props()[static_cast<std::size_t>(prop)].name;
      const int body = mj_name2id(model_.get(), mjOBJ_BODY, name.c_str());
      const bool free = model_->body_mocapid[body] < 0;
      double* pos = free ? data_->qpos + model_->jnt_qposadr[model_->body_jntadr[body]]
                         : data_->mocap_pos + 3 * model_->body_mocapid[body];
      std::copy_n(state.prop_pos_of(env, prop), 3, pos);
      if (state.status_of(env, prop) == PropStatus::kHidden) pos[2] = -50;
    }
    mj_forward(model_.get(), data_.get());
  }

  RenderScenes& scenes_;
  ModelPtr model_;
  DataPtr data_;
  int size_;
  std::vector<std::uint8_t> rgb_;
  std::unique_ptr<MujocoReference> reference_;
};

MujocoReferenceOptions low_tessellation() {
  MujocoReferenceOptions options;
  options.slices = 12;
  options.stacks = 8;
  options.quads = 4;
  return options;
}

// cpu, mjr_low and mjr at one size.
void compare_renderers(const SuiteOptions& options, RenderScenes& scenes, int size, int done,
                       int total, std::vector<Measurement>& rows) {
  constexpr int kPlainEnvs = 4;
  const std::string suffix = std::to_string(size);
  CpuRenderLoop cpu(scenes, size);
  MujocoRenderLoop usual(scenes, size, {});
  MujocoRenderLoop low(scenes, size, low_tessellation());
  const auto usual_rate = [&] { return usual.rate(kPlainEnvs); };
  const Comparison best = interleave(
      options, [&] { return cpu.rate(4); }, usual_rate, done, total);
  rows.push_back(
      make_measurement("render.cpu." + suffix, "images/s", "render.mjr", best, options.rounds));
  const Comparison fast = interleave(
      options, [&] { return low.rate(kPlainEnvs); }, usual_rate, done + 1, total);
  rows.push_back(
      make_measurement("render.mjr_low." + suffix, "images/s", "render.mjr", fast, options.rounds));
  rows.push_back({"render.mjr." + suffix, best.baseline, "images/s", "render.mjr", best.baseline,
                  1.0, options.rounds});
}

}  // namespace

std::vector<Measurement> run_render(const SuiteOptions& options) {
  constexpr int kSizes[] = {64, 128, 256};
  constexpr int kSteps = 25;
  const std::string id = ids_or(options, {kMainId}).front();
  const int n = envs_or(options, 32);
  const int most = threads_or_all(options.threads);
  const int total = 8 + most;
  int done = 0;

  std::vector<Measurement> rows;
  RenderScenes scenes(id, n);
  for (const int size : kSizes) {
    compare_renderers(options, scenes, size, done, total, rows);
    done += 2;
  }

  MakeOptions rgb = rollout_options(n, 1);
  rgb.obs_mode = ObsMode::kRgb;
  Rollout with_images(id, rgb, options.policy);
  Rollout without(id, rollout_options(n, 1), options.policy);
  CpuRenderLoop alone(scenes, rgb.images.width);
  const Comparison inside = interleave(
      options, [&] { return kCameras * with_images.rate(kSteps); },
      [&] { return alone.rate(kSteps); }, done++, total);
  rows.push_back(
      make_measurement("render.rollout", "images/s", "the renderer alone", inside, options.rounds));
  const Comparison state = interleave(
      options, [&] { return with_images.rate(kSteps); }, [&] { return without.rate(kSteps); },
      done++, total);
  rows.push_back(
      make_measurement("render.vs_state", "env steps/s", "a state rollout", state, options.rounds));
  for (int threads = 1; threads <= most; ++threads) {
    MakeOptions more = rgb;
    more.threads = threads;
    Rollout several(id, more, options.policy);
    const Comparison scaling = interleave(
        options, [&] { return several.rate(kSteps); }, [&] { return with_images.rate(kSteps); },
        done++, total);
    rows.push_back(make_measurement("render.scaling." + std::to_string(threads), "env steps/s",
                                    "one thread", scaling, options.rounds));
  }
  return rows;
}

}  // namespace engram::bench
