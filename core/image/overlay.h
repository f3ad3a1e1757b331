// Text and shapes over images for people. They are data: tasks fill them in, media/ draws them.
// Never part of observations.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace engram {

struct OverlayColor {
  std::uint8_t red = 255;
  std::uint8_t green = 255;
  std::uint8_t blue = 255;
  double opacity = 1;  // 0 to 1
};

// Places and lengths are those of an image whose shorter side has 512 pixels; they grow and
// shrink with it. x goes right, y goes down.
struct OverlayPoint {
  double x = 0;
  double y = 0;
};

struct OverlayText {
  OverlayPoint baseline;  // where it begins
  std::string text;
  double scale = 1;  // 1: capitals of 21 pixels
  OverlayColor color = {};
};

// A filled square with a border inside it.
struct OverlaySwatch {
  OverlayPoint corner;  // left, top
  double size = 22;
  OverlayColor color;
  OverlayColor border = {};
};

struct OverlayPanel {
  OverlayPoint corner;
  double width = 0;
  double height = 0;
  OverlayColor color = {0, 0, 0, 0.7};
};

struct OverlayLine {
  std::vector<OverlayPoint> points;
  double width = 1;
  OverlayColor color = {};
};

struct OverlayDisc {
  OverlayPoint center;
  double radius = 1;
  OverlayColor color = {};
};

using OverlayItem =
    std::variant<OverlayText, OverlaySwatch, OverlayPanel, OverlayLine, OverlayDisc>;

// Later items cover earlier ones.
struct Overlay {
  double width = 512;  // of the image
  double height = 512;
  std::vector<OverlayItem> items;

  template <class Item>
  void add(Item item) {
    items.emplace_back(std::move(item));
  }
};

}  // namespace engram
