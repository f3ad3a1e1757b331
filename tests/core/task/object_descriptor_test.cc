#include "core/task/object_descriptor.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

TEST_CASE("Colours are named by hue, and pale ones by lightness", "[objects]") {
  const auto name = [](double red, double green, double blue) {
    return kObjectColorNames[static_cast<std::size_t>(nearest_object_color(red, green, blue))];
  };
  CHECK(name(1, 0, 0) == "red");
  CHECK(name(210 / 255.0, 80 / 255.0, 80 / 255.0) == "red");
  CHECK(name(0.5, 0, 0) == "maroon");
  CHECK(name(1, 0.5, 0) == "orange");
  CHECK(name(0, 0.5, 0.5) == "teal");
  CHECK(name(30 / 255.0, 180 / 255.0, 30 / 255.0) == "green");
  CHECK(name(12 / 255.0, 42 / 255.0, 160 / 255.0) == "blue");
  CHECK(name(147 / 255.0, 0, 211 / 255.0) == "magenta");
  CHECK(name(1, 1, 1) == "white");
  CHECK(name(160 / 255.0, 160 / 255.0, 170 / 255.0) == "grey");
  CHECK(name(0.05, 0.05, 0.05) == "black");
}

}  // namespace
}  // namespace engram
