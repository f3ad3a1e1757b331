// Words for what scenes contain, for the annotators of families.
#pragma once

#include <Eigen/Dense>
#include <span>
#include <string>
#include <vector>

#include "core/sim/state.h"
#include "mjcf/prop.h"

namespace engram::tasks {

// "a", "a and b", "a, b and c".
std::string enumerate(std::span<const std::string> items);

// Properties by which an object is named.
struct NamedBy {
  bool color = false;
  bool shape = false;  // otherwise it is a cube
};

// "blue cube", "cross", "green T shape".
std::string name_object(const mjcf::Prop& prop, NamedBy by);

// "red", ...: the nearest of the names that objects have.
std::string name_color(const mjcf::Rgba& rgba);

// A length in whole centimetres, "-12 cm".
std::string in_centimetres(double metres);

// An angle in whole degrees, "-12 degrees".
std::string in_degrees(double radians);

// True if the tool has come so near to a point, m, that approaching it is over.
bool tool_is_at(const State& state, int env, const Eigen::Vector3d& point, double radius);

}  // namespace engram::tasks
