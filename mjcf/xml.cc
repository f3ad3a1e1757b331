#include "mjcf/xml.h"

#include <array>
#include <charconv>

namespace engram::mjcf {
namespace {

// The shortest text that reads back as the same double.
std::string to_text(double number) {
  std::array<char, 32> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number);
  return {buffer.data(), result.ptr};
}

}  // namespace

Element& add(Element& parent, const char* tag) { return *parent.InsertNewChildElement(tag); }

void set(Element& element, const char* attribute, const std::string& text) {
  element.SetAttribute(attribute, text.c_str());
}

void set(Element& element, const char* attribute, std::span<const double> numbers) {
  std::string text;
  for (const double number : numbers) {
    if (!text.empty()) text += ' ';
    text += to_text(number);
  }
  set(element, attribute, text);
}

void set(Element& element, const char* attribute, std::initializer_list<double> numbers) {
  set(element, attribute, std::span<const double>(numbers.begin(), numbers.size()));
}

void set(Element& element, const char* attribute, double number) {
  set(element, attribute, {number});
}

}  // namespace engram::mjcf
