#include "render/egl/target.h"

#include <cstring>

namespace engram::gl {

RenderTarget::RenderTarget(const Gl& gl, int width, int height, int samples)
    : gl_(&gl),
      width_(width),
      height_(height),
      pixels_(4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
  color_ = make_framebuffer();
  attach(GL_COLOR_ATTACHMENT0, make_buffer(GL_RGBA8, samples));
  attach(GL_DEPTH_ATTACHMENT, make_buffer(GL_DEPTH_COMPONENT24, samples));
  ok_ = complete();
  resolved_ = color_;
  if (samples > 1) {
    resolved_ = make_framebuffer();
    attach(GL_COLOR_ATTACHMENT0, make_buffer(GL_RGBA8, 1));
    ok_ = ok_ && complete();
  }
}

GLuint RenderTarget::make_buffer(GLenum format, int samples) {
  GLuint buffer = 0;
  gl_->GenRenderbuffers(1, &buffer);
  gl_->BindRenderbuffer(GL_RENDERBUFFER, buffer);
  if (samples > 1) {
    gl_->RenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width_, height_);
  } else {
    gl_->RenderbufferStorage(GL_RENDERBUFFER, format, width_, height_);
  }
  buffers_.push_back(buffer);
  return buffer;
}

GLuint RenderTarget::make_framebuffer() {
  GLuint framebuffer = 0;
  gl_->GenFramebuffers(1, &framebuffer);
  gl_->BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  return framebuffer;
}

void RenderTarget::attach(GLenum where, GLuint buffer) {
  gl_->FramebufferRenderbuffer(GL_FRAMEBUFFER, where, GL_RENDERBUFFER, buffer);
}

bool RenderTarget::complete() {
  return gl_->CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
}

void RenderTarget::begin_color(const float* background) {
  gl_->BindFramebuffer(GL_FRAMEBUFFER, color_);
  gl_->Viewport(0, 0, width_, height_);
  const float color[4] = {background[0], background[1], background[2], 1};
  const float far = 1;
  gl_->ClearBufferfv(GL_COLOR, 0, color);
  gl_->ClearBufferfv(GL_DEPTH, 0, &far);
}

void RenderTarget::read_color(const RenderImage& image) {
  if (resolved_ != color_) {
    gl_->BindFramebuffer(GL_READ_FRAMEBUFFER, color_);
    gl_->BindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved_);
    gl_->BlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT,
                         GL_NEAREST);
  }
  gl_->BindFramebuffer(GL_READ_FRAMEBUFFER, resolved_);
  gl_->ReadBuffer(GL_COLOR_ATTACHMENT0);
  gl_->ReadPixels(0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, pixels_.data());
  const std::uint8_t* from = pixels_.data();
  for (int y = 0; y < height_; ++y) {
    std::uint8_t* to = image.rgb + y * image.row_stride;
    for (int x = 0; x < width_; ++x, from += 4, to += image.pixel_stride) {
      to[0] = from[0];
      to[1] = from[1];
      to[2] = from[2];
    }
  }
}

void RenderTarget::begin_data() {
  if (data_ == 0) {
    data_ = make_framebuffer();
    attach(GL_COLOR_ATTACHMENT0, make_buffer(GL_R32F, 1));
    attach(GL_COLOR_ATTACHMENT1, make_buffer(GL_R32I, 1));
    attach(GL_DEPTH_ATTACHMENT, make_buffer(GL_DEPTH_COMPONENT24, 1));
    const GLenum both[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    gl_->DrawBuffers(2, both);
    ok_ = ok_ && complete();
  }
  gl_->BindFramebuffer(GL_FRAMEBUFFER, data_);
  gl_->Viewport(0, 0, width_, height_);
  const float nothing[4] = {};
  const GLint background[4] = {};
  const float far = 1;
  gl_->ClearBufferfv(GL_COLOR, 0, nothing);
  gl_->ClearBufferiv(GL_COLOR, 1, background);
  gl_->ClearBufferfv(GL_DEPTH, 0, &far);
}

void RenderTarget::read_data(const RenderImage& image) {
  if (image.depth != nullptr) {
    gl_->ReadBuffer(GL_COLOR_ATTACHMENT0);
    gl_->ReadPixels(0, 0, width_, height_, GL_RED, GL_FLOAT, image.depth);
  }
  if (image.segment != nullptr) {
    gl_->ReadBuffer(GL_COLOR_ATTACHMENT1);
    gl_->ReadPixels(0, 0, width_, height_, GL_RED_INTEGER, GL_INT, image.segment);
  }
  if (image.depth_mm != nullptr) {
    gl_->ReadBuffer(GL_COLOR_ATTACHMENT0);
    gl_->ReadPixels(0, 0, width_, height_, GL_RED, GL_FLOAT, pixels_.data());
    store_cells<float>(image, image.depth_mm, to_millimetres);
  }
  if (image.segment_id != nullptr) {
    gl_->ReadBuffer(GL_COLOR_ATTACHMENT1);
    gl_->ReadPixels(0, 0, width_, height_, GL_RED_INTEGER, GL_INT, pixels_.data());
    store_cells<std::int32_t>(image, image.segment_id, [](std::int32_t segment) {
      return static_cast<std::int16_t>(segment);
    });
  }
}

// Converts `pixels_`, which holds four bytes for each pixel.
template <class From, class Convert>
void RenderTarget::store_cells(const RenderImage& image, std::int16_t* out, Convert convert) const {
  const std::uint8_t* from = pixels_.data();
  for (int y = 0; y < height_; ++y) {
    std::int16_t* to = out + y * image.cell_row;
    for (int x = 0; x < width_; ++x, from += sizeof(From), to += image.cell_step) {
      From value;
      std::memcpy(&value, from, sizeof value);
      *to = convert(value);
    }
  }
}

void RenderTarget::release() {
  const GLuint framebuffers[] = {color_, resolved_ == color_ ? 0 : resolved_, data_};
  gl_->DeleteFramebuffers(3, framebuffers);
  gl_->DeleteRenderbuffers(static_cast<GLsizei>(buffers_.size()), buffers_.data());
  buffers_.clear();
}

}  // namespace engram::gl
