// A drawing surface: images side by side, with text and simple shapes on them.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace engram {

struct Color {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
  double opacity = 1;  // 0 to 1

  bool operator==(const Color&) const = default;
};

inline constexpr Color kBlack = {0, 0, 0};
inline constexpr Color kWhite = {255, 255, 255};
inline constexpr Color kOutline = {20, 20, 20};  // around text

// In pixels from the top left corner; fractions of a pixel count.
struct Point {
  double x = 0;
  double y = 0;
};

struct Rectangle {
  double x = 0;
  double y = 0;
  double width = 0;
  double height = 0;
};

// Drawing outside of the canvas is clipped.
class Canvas {
 public:
  // Throws Error if a side is not of 1 to 32767 pixels or memory is short.
  Canvas(int width, int height, Color background = kBlack);
  ~Canvas();
  Canvas(Canvas&&) noexcept;
  Canvas& operator=(Canvas&&) noexcept;

  int width() const;
  int height() const;

  // Copies an image, pixel by pixel. Throws Error if rgb is not (height, width, 3).
  void blit(int x, int y, int width, int height, std::span<const std::uint8_t> rgb);
  // Copies an image, resampled to fill `target`.
  void blit_scaled(const Rectangle& target, int width, int height,
                   std::span<const std::uint8_t> rgb);

  // Text from `baseline` to the right, with a dark outline. Scale 1 has capitals of 21 pixels, as
  // OpenCV's simplex font does.
  void text(Point baseline, const std::string& text, double scale = 1, Color color = kWhite);

  void fill(const Rectangle& area, Color color);
  // A filled square with its left top corner there. Its border of 2 pixels (times scale) is inside.
  void swatch(Point corner, double size, Color color, Color border, double scale = 1);
  void line(std::span<const Point> points, double width, Color color);
  void disc(Point center, double radius, Color color);

  // (height, width, 3); throws Error if `out` is of another length.
  void copy_to(std::span<std::uint8_t> out) const;
  std::vector<std::uint8_t> rgb() const;

 private:
  struct Surface;
  std::unique_ptr<Surface> surface_;
};

}  // namespace engram
