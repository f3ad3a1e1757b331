// Framebuffers of one size: what images are drawn into and read from.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image/renderer.h"
#include "render/egl/gl_functions.h"

namespace engram::gl {

class RenderTarget {
 public:
  // Needs a current context; everything is freed with it. Check ok() before use.
  RenderTarget(const Gl& gl, int width, int height, int samples);

  bool ok() const { return ok_; }
  int width() const { return width_; }
  int height() const { return height_; }

  void begin_color(const float* background);
  void read_color(const RenderImage& image);
  void begin_data();
  void read_data(const RenderImage& image);

  // Frees the framebuffers; the context must be current.
  void release();

 private:
  GLuint make_buffer(GLenum format, int samples);
  GLuint make_framebuffer();
  void attach(GLenum where, GLuint buffer);
  bool complete();
  template <class From, class Convert>
  void store_cells(const RenderImage& image, std::int16_t* out, Convert convert) const;

  const Gl* gl_;
  int width_, height_;
  bool ok_ = false;
  GLuint color_ = 0;     // framebuffers
  GLuint resolved_ = 0;  // without multisampling, `color_` itself
  GLuint data_ = 0;      // made on first use
  std::vector<GLuint> buffers_;
  std::vector<std::uint8_t> pixels_;  // RGBA, or a word each
};

}  // namespace engram::gl
