// A thin layer over tinyxml2, for writing MJCF.
#pragma once

#include <tinyxml2.h>

#include <array>
#include <initializer_list>
#include <span>
#include <string>

#include "core/math/eigen_types.h"

namespace engram::mjcf {

using Element = tinyxml2::XMLElement;

// Appends an empty child.
Element& add(Element& parent, const char* tag);

// Set an attribute. Numbers are written so that reading them back gives the same bits.
void set(Element& element, const char* attribute, const std::string& text);
void set(Element& element, const char* attribute, std::span<const double> numbers);
void set(Element& element, const char* attribute, std::initializer_list<double> numbers);
void set(Element& element, const char* attribute, double number);

// What MuJoCo would work out itself, its versions work out to other bits. So rotations are
// quaternions whose computed norm is exactly 1, and inertia has principal moments.

// Sets `quat`; nothing for no rotation. `rpy`: about fixed axes, rad.
void set_rotation(Element& element, const Eigen::Quaterniond& rotation);
void set_rotation(Element& element, const std::array<double, 3>& rpy);

// Appends an inertia about the centre of mass, in the body's axes, as xx, yy, zz, xy, xz, yz.
void add_inertial(Element& body, double mass, const std::array<double, 3>& center,
                  const std::array<double, 6>& inertia);

}  // namespace engram::mjcf
