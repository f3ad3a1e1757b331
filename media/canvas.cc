#include "media/canvas.h"

#include <cairo.h>

#include <algorithm>
#include <cstring>
#include <numbers>

#include "core/base/error.h"

namespace engram {
namespace {

constexpr int kLargestSide = 32767;       // of cairo's surfaces
constexpr double kPixelsPerScale = 28.8;  // font size at scale 1: DejaVu's capitals are 0.729 of it
constexpr double kOutlineWidth = 2;       // added to the text's strokes, half on either side
constexpr double kBorderWidth = 2;

void use(cairo_t* context, Color color) {
  cairo_set_source_rgba(context, color.red / 255.0, color.green / 255.0, color.blue / 255.0,
                        color.opacity);
}

// Without hinting, text is the same at every size and place.
void choose_font(cairo_t* context, double scale) {
  cairo_select_font_face(context, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(context, kPixelsPerScale * scale);
  cairo_font_options_t* options = cairo_font_options_create();
  cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
  cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
  cairo_set_font_options(context, options);
  cairo_font_options_destroy(options);
}

std::size_t rgb_length(int width, int height) {
  return 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

std::uint32_t pack(const std::uint8_t* rgb) {
  return 0xFF000000U | static_cast<std::uint32_t>(rgb[0]) << 16U |
         static_cast<std::uint32_t>(rgb[1]) << 8U | rgb[2];
}

std::uint8_t* row_of(cairo_surface_t* surface, int y) {
  return cairo_image_surface_get_data(surface) +
         static_cast<std::ptrdiff_t>(y) * cairo_image_surface_get_stride(surface);
}

}  // namespace

struct Canvas::Surface {
  Surface(int width, int height)
      : image(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height)),
        context(cairo_create(image)) {}
  ~Surface() {
    cairo_destroy(context);
    cairo_surface_destroy(image);
  }
  Surface(const Surface&) = delete;
  Surface& operator=(const Surface&) = delete;

  cairo_surface_t* image;
  cairo_t* context;
};

Canvas::Canvas(int width, int height, Color background) {
  if (width < 1 || height < 1 || width > kLargestSide || height > kLargestSide) {
    throw Error(Error::kInvalidArgument, "image of " + std::to_string(width) + " x " +
                                             std::to_string(height) +
                                             " pixels; sides of 1 to 32767 allowed");
  }
  surface_ = std::make_unique<Surface>(width, height);
  if (cairo_status(surface_->context) != CAIRO_STATUS_SUCCESS) {
    throw Error(Error::kUnavailable,
                std::string("image: ") + cairo_status_to_string(cairo_status(surface_->context)));
  }
  use(surface_->context, background);
  cairo_paint(surface_->context);
}

Canvas::~Canvas() = default;
Canvas::Canvas(Canvas&&) noexcept = default;
Canvas& Canvas::operator=(Canvas&&) noexcept = default;

int Canvas::width() const { return cairo_image_surface_get_width(surface_->image); }
int Canvas::height() const { return cairo_image_surface_get_height(surface_->image); }

void Canvas::blit(int x, int y, int width, int height, std::span<const std::uint8_t> rgb) {
  require_length("image", rgb.size(), rgb_length(width, height));
  cairo_surface_flush(surface_->image);
  const int left = std::max(0, -x);
  const int right = std::min(width, this->width() - x);
  for (int row = std::max(0, -y); row < std::min(height, this->height() - y); ++row) {
    std::uint8_t* out = row_of(surface_->image, y + row);
    const std::uint8_t* in = rgb.data() + rgb_length(width, row);
    for (int column = left; column < right; ++column) {
      const std::uint32_t pixel = pack(in + rgb_length(column, 1));
      std::memcpy(out + 4 * static_cast<std::ptrdiff_t>(x + column), &pixel, sizeof(pixel));
    }
  }
  cairo_surface_mark_dirty(surface_->image);
}

void Canvas::blit_scaled(const Rectangle& target, int width, int height,
                         std::span<const std::uint8_t> rgb) {
  Canvas source(width, height);
  source.blit(0, 0, width, height, rgb);
  cairo_t* context = surface_->context;
  cairo_save(context);
  cairo_rectangle(context, target.x, target.y, target.width, target.height);
  cairo_clip(context);
  cairo_translate(context, target.x, target.y);
  cairo_scale(context, target.width / width, target.height / height);
  cairo_set_source_surface(context, source.surface_->image, 0, 0);
  cairo_pattern_t* pattern = cairo_get_source(context);
  cairo_pattern_set_filter(pattern, CAIRO_FILTER_BEST);
  cairo_pattern_set_extend(pattern, CAIRO_EXTEND_PAD);  // edges do not fade
  cairo_paint(context);
  cairo_restore(context);
}

void Canvas::text(Point baseline, const std::string& text, double scale, Color color) {
  cairo_t* context = surface_->context;
  choose_font(context, scale);
  cairo_new_path(context);
  cairo_move_to(context, baseline.x, baseline.y);
  cairo_text_path(context, text.c_str());
  cairo_set_line_join(context, CAIRO_LINE_JOIN_ROUND);
  // The outline of small text has to be visible, too.
  cairo_set_line_width(context, kOutlineWidth * std::max(1.0, scale));
  use(context, kOutline);
  cairo_stroke_preserve(context);
  use(context, color);
  cairo_fill(context);
}

void Canvas::fill(const Rectangle& area, Color color) {
  use(surface_->context, color);
  cairo_rectangle(surface_->context, area.x, area.y, area.width, area.height);
  cairo_fill(surface_->context);
}

void Canvas::swatch(Point corner, double size, Color color, Color border, double scale) {
  const double width = kBorderWidth * scale;
  fill({corner.x, corner.y, size, size}, border);
  fill({corner.x + width, corner.y + width, size - 2 * width, size - 2 * width}, color);
}

void Canvas::line(std::span<const Point> points, double width, Color color) {
  cairo_t* context = surface_->context;
  cairo_new_path(context);
  for (const Point& point : points) cairo_line_to(context, point.x, point.y);
  cairo_set_line_width(context, width);
  cairo_set_line_join(context, CAIRO_LINE_JOIN_ROUND);
  cairo_set_line_cap(context, CAIRO_LINE_CAP_ROUND);
  use(context, color);
  cairo_stroke(context);
}

void Canvas::disc(Point center, double radius, Color color) {
  use(surface_->context, color);
  cairo_new_path(surface_->context);
  cairo_arc(surface_->context, center.x, center.y, radius, 0, 2 * std::numbers::pi);
  cairo_fill(surface_->context);
}

void Canvas::copy_to(std::span<std::uint8_t> out) const {
  require_length("image", out.size(), rgb_length(width(), height()));
  cairo_surface_flush(surface_->image);
  std::uint8_t* to = out.data();
  for (int y = 0; y < height(); ++y) {
    const std::uint8_t* row = row_of(surface_->image, y);
    for (int x = 0; x < width(); ++x, to += 3) {
      std::uint32_t pixel = 0;
      std::memcpy(&pixel, row + 4 * static_cast<std::ptrdiff_t>(x), sizeof(pixel));
      to[0] = static_cast<std::uint8_t>(pixel >> 16U);
      to[1] = static_cast<std::uint8_t>(pixel >> 8U);
      to[2] = static_cast<std::uint8_t>(pixel);
    }
  }
}

std::vector<std::uint8_t> Canvas::rgb() const {
  std::vector<std::uint8_t> out(rgb_length(width(), height()));
  copy_to(out);
  return out;
}

}  // namespace engram
