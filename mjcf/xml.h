// A thin layer over tinyxml2, for writing MJCF.
#pragma once

#include <tinyxml2.h>

#include <initializer_list>
#include <span>
#include <string>

namespace engram::mjcf {

using Element = tinyxml2::XMLElement;

// Appends an empty child.
Element& add(Element& parent, const char* tag);

// Set an attribute. Numbers are written so that reading them back gives the same bits.
void set(Element& element, const char* attribute, const std::string& text);
void set(Element& element, const char* attribute, std::span<const double> numbers);
void set(Element& element, const char* attribute, std::initializer_list<double> numbers);
void set(Element& element, const char* attribute, double number);

}  // namespace engram::mjcf
