// Draws images in one OpenGL context: programs, shadow maps and framebuffers.
#pragma once

#include <Eigen/Dense>
#include <span>
#include <vector>

#include "render/egl/egl_options.h"
#include "render/egl/gl_functions.h"
#include "render/egl/gl_shaders.h"
#include "render/egl/target.h"
#include "render/egl/view.h"

namespace engram::gl {

// The context that it was made in must be current in all calls. All that it holds is freed with
// that context.
class GlPainter {
 public:
  // Throws Error. `scene` and `shapes` must outlive it.
  GlPainter(const Gl& gl, const RenderScene& scene, const Shapes& shapes,
            const EglRendererOptions& options);

  void paint(const RenderInstances& rows, std::span<const RenderImage> images);

 private:
  struct ColorProgram {
    GLuint id = 0;
    GLint clip_from_world = -1;
    GLint eye = -1;
    GLint light_from_world = -1;
    GLint shadow_width = -1;
    GLint ambient = -1;
    GLint to_light = -1;
    GLint light_color = -1;
  };
  struct Program {
    GLuint id = 0;
    GLint clip_from_world = -1;
  };

  void make_arrays();
  ColorProgram make_color(bool patterns) const;
  // Lights of the images that follow; null: the scene's.
  void light(const RenderLighting* lighting);
  void set_lights(const ColorProgram& program, const RenderLight* lights, const float* ambient);
  void set_shadow(const ColorProgram& program, std::size_t light, const Viewpoint& view,
                  float width);
  void make_wood();
  void make_shadow_map();
  void draw_shadows(const RenderInstances& rows);
  void paint_image(const RenderInstances& rows, const RenderImage& image);
  void upload();
  void draw(bool patterned);
  RenderTarget* target(int width, int height);

  const Gl& gl_;
  const RenderScene& scene_;
  const Shapes& shapes_;
  EglRendererOptions options_;
  DrawList list_;
  std::vector<Eigen::Vector3f> to_light_;
  bool relit_ = false;  // the lights are not the scene's
  ColorProgram plain_;
  ColorProgram patterned_;  // none if no geom has a pattern
  Program data_;
  Program depth_;
  GLuint instance_buffer_ = 0;
  std::vector<int> shadow_layer_;  // of each light; -1: none
  int shadow_layers_ = 0;
  GLuint shadow_framebuffer_ = 0;
  GLuint shadow_map_ = 0;
  std::vector<RenderTarget> targets_;
  std::size_t next_target_ = 0;  // the one to replace when there are too many
};

}  // namespace engram::gl
