// Appearance of a prop in the objects observation.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace engram {

// Use of an object. A kPart belongs to another prop and is no object of its own.
enum class ObjectKind : std::uint8_t {
  kPart,
  kObject,  // to be touched or carried
  kBall,
  kCup,
  kBattery,
  kPeg,
  kPlace,  // where something is to be brought
  kRack,   // where something stands
  kButton,
  kLamp,
};
// Names of those behind kPart.
inline constexpr std::array<std::string_view, 9> kObjectKindNames = {
    "object", "ball", "cup", "battery", "peg", "place", "rack", "button", "lamp"};

// The shapes of kObject, in the order of the keys of the families that draw shapes.
enum class ObjectShape : std::uint8_t {
  kCube,
  kSphere,
  kCylinder,
  kCross,
  kTorus,
  kStar,
  kPyramide,
  kTShape,
  kCrescent,
};
// Names, in the spelling of the original benchmark.
inline constexpr std::array<std::string_view, 9> kObjectShapeNames = {
    "cube", "sphere", "cylinder", "cross", "torus", "star", "pyramide", "t_shape", "crescent"};

// Colours that are distinguished.
inline constexpr std::array<std::string_view, 12> kObjectColorNames = {
    "red",    "green",  "blue", "yellow", "magenta", "cyan",
    "maroon", "orange", "teal", "white",  "grey",    "black"};

// The nearest of these: by lightness where a colour is pale, else by hue and depth. 0..1 each.
int nearest_object_color(double red, double green, double blue);

struct ObjectDescriptor {
  ObjectKind kind = ObjectKind::kPart;
  int shape = -1;                     // ObjectShape, -1: none of these
  int color = 0;                      // index of kObjectColorNames
  std::array<double, 3> half_size{};  // m, of the box around it, in its body's axes
  double rest_height = 0;             // m, of a button's cap that is not pressed
  double travel = 0;                  // m, by which that sinks at most
};

}  // namespace engram
