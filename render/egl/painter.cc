#include "render/egl/painter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>

#include "core/base/error.h"
#include "render/cpu/wood.h"

namespace engram::gl {
namespace {

constexpr std::size_t kMaxTargets = 4;

const void* offset(std::size_t bytes) { return reinterpret_cast<const void*>(bytes); }

// Places that share out the unit disc evenly.
std::array<float, 2 * kShadowTaps> spiral() {
  constexpr float kGoldenAngle = 2.39996323F;
  std::array<float, 2 * kShadowTaps> places = {};
  for (std::size_t i = 0; i < kShadowTaps; ++i) {
    const float radius = std::sqrt((static_cast<float>(i) + 0.5F) / kShadowTaps);
    const float angle = kGoldenAngle * static_cast<float>(i);
    places[2 * i] = radius * std::cos(angle);
    places[2 * i + 1] = radius * std::sin(angle);
  }
  return places;
}

}  // namespace

GlPainter::GlPainter(const Gl& gl, const RenderScene& scene, const Shapes& shapes,
                     const EglRendererOptions& options)
    : gl_(gl), scene_(scene), shapes_(shapes), options_(options), list_(scene, shapes) {
  GLint max_samples = 0;
  gl_.GetIntegerv(GL_MAX_SAMPLES, &max_samples);
  if (options.samples > max_samples) {
    throw Error(Error::kUnavailable, "egl renderer: " + std::to_string(options.samples) +
                                         " samples asked for, the device has " +
                                         std::to_string(max_samples));
  }
  to_light_.resize(scene.lights.size());
  for (const RenderLight& light : scene.lights) {
    const bool casts = options.shadows && light.casts_shadow;
    shadow_layer_.push_back(casts ? shadow_layers_++ : -1);
  }
  targets_.reserve(kMaxTargets);

  make_arrays();
  plain_ = make_color(false);
  const bool patterns = std::any_of(scene.geoms.begin(), scene.geoms.end(), [](const auto& geom) {
    return geom.pattern != RenderPattern::kPlain;
  });
  if (patterns) {
    patterned_ = make_color(true);
    make_wood();
  }
  data_.id = make_data_program(gl_);
  data_.clip_from_world = gl_.GetUniformLocation(data_.id, "clip_from_world");
  if (shadow_layers_ > 0) make_shadow_map();
  light(nullptr);

  gl_.Enable(GL_DEPTH_TEST);
  gl_.Enable(GL_CULL_FACE);
  gl_.Disable(GL_DITHER);
  gl_.PixelStorei(GL_PACK_ALIGNMENT, 4);
  if (gl_.GetError() != GL_NO_ERROR) {
    throw Error(Error::kUnavailable, "egl renderer: OpenGL failed to set up; out of memory?");
  }
}

void GlPainter::make_arrays() {
  GLuint array = 0;
  gl_.GenVertexArrays(1, &array);
  gl_.BindVertexArray(array);
  GLuint buffers[3];
  gl_.GenBuffers(3, buffers);

  gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[0]);
  const auto& indices = shapes_.indices();
  gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER,
                 static_cast<GLsizeiptr>(indices.size() * sizeof indices[0]), indices.data(),
                 GL_STATIC_DRAW);

  gl_.BindBuffer(GL_ARRAY_BUFFER, buffers[1]);
  const auto& vertices = shapes_.vertices();
  gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof vertices[0]),
                 vertices.data(), GL_STATIC_DRAW);
  const auto floats = [this](GLuint attribute, int count, std::size_t size, std::size_t at) {
    gl_.EnableVertexAttribArray(attribute);
    gl_.VertexAttribPointer(attribute, count, GL_FLOAT, GL_FALSE, static_cast<GLsizei>(size),
                            offset(at));
  };
  floats(kPosition, 4, sizeof(Vertex), offsetof(Vertex, position));
  floats(kNormal, 3, sizeof(Vertex), offsetof(Vertex, normal));

  instance_buffer_ = buffers[2];
  gl_.BindBuffer(GL_ARRAY_BUFFER, instance_buffer_);
  for (GLuint k = 0; k < 3; ++k) {
    floats(kRowX + k, 4, sizeof(Instance), offsetof(Instance, row) + k * 4 * sizeof(float));
  }
  floats(kScale, 4, sizeof(Instance), offsetof(Instance, scale));
  floats(kColor, 4, sizeof(Instance), offsetof(Instance, color));
  gl_.EnableVertexAttribArray(kKind);
  gl_.VertexAttribIPointer(kKind, 2, GL_INT, sizeof(Instance), offset(offsetof(Instance, kind)));
  for (GLuint attribute = kRowX; attribute <= kKind; ++attribute) {
    gl_.VertexAttribDivisor(attribute, 1);
  }
}

GlPainter::ColorProgram GlPainter::make_color(bool patterns) const {
  ColorFeatures features;
  features.lights = static_cast<int>(scene_.lights.size());
  features.shadows = shadow_layers_ > 0;
  features.patterns = patterns;
  features.smooth = options_.samples > 1;
  ColorProgram program;
  program.id = gl::make_color_program(gl_, features);
  const auto where = [&](const char* name) { return gl_.GetUniformLocation(program.id, name); };
  program.clip_from_world = where("clip_from_world");
  program.eye = where("eye");
  program.light_from_world = where("light_from_world");
  program.shadow_width = where("shadow_width");

  program.ambient = where("ambient");
  program.to_light = where("to_light");
  program.light_color = where("light_color");

  gl_.UseProgram(program.id);
  if (patterns) {
    const float wood_size[] = {cpu::WoodTexture::kAlongLength, cpu::WoodTexture::kAcrossLength};
    gl_.Uniform1i(where("wood_texels"), kWoodUnit);
    gl_.Uniform2fv(where("wood_size"), 1, wood_size);
  }
  if (features.shadows) {
    gl_.Uniform1i(where("shadow_map"), kShadowUnit);
    gl_.Uniform1i(where("shadow_depth"), kShadowDepthUnit);
    gl_.Uniform1iv(where("shadow_layer"), features.lights, shadow_layer_.data());
    gl_.Uniform1f(where("shadow_softness"), std::tan(options_.shadow_softness));
    const auto places = spiral();
    gl_.Uniform2fv(where("spiral"), kShadowTaps, places.data());
  }
  return program;
}

void GlPainter::light(const RenderLighting* lighting) {
  relit_ = lighting != nullptr;
  const RenderLight* lights = relit_ ? lighting->lights.data() : scene_.lights.data();
  for (std::size_t i = 0; i < to_light_.size(); ++i) {
    to_light_[i] = -Eigen::Map<const Eigen::Vector3f>(lights[i].direction).normalized();
  }
  for (const ColorProgram* program : {&plain_, &patterned_}) {
    if (program->id != 0) {
      set_lights(*program, lights, relit_ ? lighting->ambient : scene_.ambient);
    }
  }
}

void GlPainter::set_lights(const ColorProgram& program, const RenderLight* lights,
                           const float* ambient) {
  gl_.UseProgram(program.id);
  gl_.Uniform3fv(program.ambient, 1, ambient);
  for (std::size_t i = 0; i < to_light_.size(); ++i) {
    const auto index = static_cast<GLint>(i);
    gl_.Uniform3fv(program.to_light + index, 1, to_light_[i].data());
    gl_.Uniform3fv(program.light_color + index, 1, lights[i].color);
  }
}

// The CPU renderer's texture, with its own coarser levels.
void GlPainter::make_wood() {
  using cpu::WoodTexture;
  const WoodTexture wood = cpu::wood_texture();
  GLuint texture = 0;
  gl_.GenTextures(1, &texture);
  gl_.ActiveTexture(GL_TEXTURE0 + kWoodUnit);
  gl_.BindTexture(GL_TEXTURE_2D, texture);
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  for (int level = 0; level < WoodTexture::kLevels; ++level) {
    gl_.TexImage2D(GL_TEXTURE_2D, level, GL_R8, WoodTexture::kAlong >> level,
                   WoodTexture::kAcross >> level, 0, GL_RED, GL_UNSIGNED_BYTE,
                   wood.texels + wood.offset[level]);
  }
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, WoodTexture::kLevels - 1);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST_MIPMAP_NEAREST);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}

void GlPainter::make_shadow_map() {
  depth_.id = make_depth_program(gl_);
  depth_.clip_from_world = gl_.GetUniformLocation(depth_.id, "clip_from_world");
  gl_.GenTextures(1, &shadow_map_);
  gl_.ActiveTexture(GL_TEXTURE0 + kShadowUnit);
  gl_.BindTexture(GL_TEXTURE_2D_ARRAY, shadow_map_);
  gl_.ActiveTexture(GL_TEXTURE0 + kShadowDepthUnit);
  gl_.BindTexture(GL_TEXTURE_2D_ARRAY, shadow_map_);
  const int size = options_.shadow_map_size;
  gl_.TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_DEPTH_COMPONENT32F, size, size, shadow_layers_, 0,
                 GL_DEPTH_COMPONENT, GL_FLOAT, nullptr);

  GLuint samplers[2];  // one compares depths, one reads them
  gl_.GenSamplers(2, samplers);
  const float outside[4] = {1, 1, 1, 1};
  for (const GLuint sampler : samplers) {
    gl_.SamplerParameterfv(sampler, GL_TEXTURE_BORDER_COLOR, outside);
    gl_.SamplerParameteri(sampler, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
    gl_.SamplerParameteri(sampler, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
    gl_.SamplerParameteri(sampler, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl_.SamplerParameteri(sampler, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  }
  gl_.SamplerParameteri(samplers[0], GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  gl_.SamplerParameteri(samplers[0], GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl_.SamplerParameteri(samplers[0], GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl_.BindSampler(kShadowUnit, samplers[0]);
  gl_.BindSampler(kShadowDepthUnit, samplers[1]);
  gl_.GenFramebuffers(1, &shadow_framebuffer_);
}

void GlPainter::paint(const RenderInstances& rows, std::span<const RenderImage> images) {
  if (rows.lighting != nullptr || relit_) light(rows.lighting);
  if (shadow_layers_ > 0) draw_shadows(rows);
  for (const RenderImage& image : images) {
    const bool known =
        image.camera >= 0 && static_cast<std::size_t>(image.camera) < scene_.cameras.size();
    const bool fits = image.width > 0 && image.height > 0 && image.width <= options_.max_width &&
                      image.height <= options_.max_height;
    if (known && fits) paint_image(rows, image);
  }
}

void GlPainter::draw_shadows(const RenderInstances& rows) {
  list_.fill_for_light(rows);
  upload();
  const int size = options_.shadow_map_size;
  gl_.BindFramebuffer(GL_FRAMEBUFFER, shadow_framebuffer_);
  gl_.DrawBuffer(GL_NONE);
  gl_.ReadBuffer(GL_NONE);
  gl_.Viewport(0, 0, size, size);
  gl_.FrontFace(GL_CCW);
  gl_.CullFace(GL_FRONT);
  float width = 0;
  for (std::size_t i = 0; i < shadow_layer_.size(); ++i) {
    if (shadow_layer_[i] < 0) continue;
    const Viewpoint view = list_.light_viewpoint(rows, to_light_[i], width);
    gl_.FramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, shadow_map_, 0,
                                shadow_layer_[i]);
    const float far = 1;
    gl_.ClearBufferfv(GL_DEPTH, 0, &far);
    gl_.UseProgram(depth_.id);
    gl_.UniformMatrix4fv(depth_.clip_from_world, 1, GL_FALSE, view.clip_from_world.data());
    draw(false);
    draw(true);
    set_shadow(plain_, i, view, width);
    if (patterned_.id != 0) set_shadow(patterned_, i, view, width);
  }
}

void GlPainter::set_shadow(const ColorProgram& program, std::size_t light, const Viewpoint& view,
                           float width) {
  const auto index = static_cast<GLint>(light);
  gl_.UseProgram(program.id);
  gl_.UniformMatrix4fv(program.light_from_world + index, 1, GL_FALSE, view.clip_from_world.data());
  gl_.Uniform1f(program.shadow_width + index, width);
}

void GlPainter::paint_image(const RenderInstances& rows, const RenderImage& image) {
  RenderTarget* to = target(image.width, image.height);
  if (to == nullptr) return;
  const Viewpoint view = camera_viewpoint(scene_, rows, image.camera, image.width, image.height);
  list_.fill_for_camera(rows, view, options_.tolerance);
  upload();
  gl_.FrontFace(GL_CW);  // y is flipped
  gl_.CullFace(GL_BACK);
  if (image.rgb != nullptr) {
    to->begin_color(scene_.background);
    for (const bool patterned : {false, true}) {
      const ColorProgram& program = patterned ? patterned_ : plain_;
      if (program.id == 0) continue;
      gl_.UseProgram(program.id);
      gl_.UniformMatrix4fv(program.clip_from_world, 1, GL_FALSE, view.clip_from_world.data());
      gl_.Uniform3fv(program.eye, 1, view.position.data());
      draw(patterned);
    }
    to->read_color(image);
  }
  if (image.depth != nullptr || image.segment != nullptr || image.depth_mm != nullptr ||
      image.segment_id != nullptr) {
    to->begin_data();
    gl_.UseProgram(data_.id);
    gl_.UniformMatrix4fv(data_.clip_from_world, 1, GL_FALSE, view.clip_from_world.data());
    draw(false);
    draw(true);
    to->read_data(image);
  }
}

void GlPainter::upload() {
  const auto& instances = list_.instances();
  if (instances.empty()) return;
  gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(instances.size() * sizeof instances[0]),
                 instances.data(), GL_STREAM_DRAW);
}

void GlPainter::draw(bool patterned) {
  for (const DrawCall& run : list_.draws()) {
    if (run.patterned != patterned) continue;
    const ShapePart& part = shapes_.parts()[static_cast<std::size_t>(run.part)];
    gl_.DrawElementsInstancedBaseVertexBaseInstance(
        GL_TRIANGLES, static_cast<GLsizei>(part.index_count), GL_UNSIGNED_INT,
        offset(part.first_index * sizeof(std::uint32_t)), run.count, part.first_vertex,
        static_cast<GLuint>(run.first));
  }
}

RenderTarget* GlPainter::target(int width, int height) {
  const auto found = std::find_if(targets_.begin(), targets_.end(), [&](const RenderTarget& each) {
    return each.width() == width && each.height() == height;
  });
  if (found != targets_.end()) return found->ok() ? &*found : nullptr;
  if (targets_.size() < kMaxTargets) {
    targets_.emplace_back(gl_, width, height, options_.samples);
    return targets_.back().ok() ? &targets_.back() : nullptr;
  }
  RenderTarget& place = targets_[next_target_];
  next_target_ = (next_target_ + 1) % kMaxTargets;
  place.release();
  place = RenderTarget(gl_, width, height, options_.samples);
  return place.ok() ? &place : nullptr;
}

}  // namespace engram::gl
