#include "render/make_renderer.h"

#include "core/base/error.h"
#include "render/cpu/cpu_renderer.h"
#include "render/egl/egl_renderer.h"

namespace engram {
namespace {

constexpr int kShadowRays = 8;
constexpr int kEglSamples = 4;

}  // namespace

std::unique_ptr<Renderer> make_renderer(const RenderScene& scene, const ImageSourceOptions& options,
                                        int workers) {
  return make_renderer_on(InstructionSet::kAuto, scene, options, workers);
}

std::unique_ptr<Renderer> make_renderer_on(InstructionSet set, const RenderScene& scene,
                                           const ImageSourceOptions& options, int workers) {
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

}  // namespace engram
