#include "protocol/formats/printable.h"

#include <cstddef>

namespace engram {
namespace {

// The control character at the beginning of the text: how many bytes it has, and its number. UTF-8
// has a second kind of them, of two bytes, that some terminals obey.
struct Control {
  std::size_t length = 0;  // 0: there is none
  unsigned number = 0;
};

Control control_at(std::string_view text) {
  constexpr unsigned kDelete = 0x7f;
  const auto byte = [&text](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
  };
  if (byte(0) < ' ' || byte(0) == kDelete) return {1, byte(0)};
  if (byte(0) == 0xc2 && byte(1) >= 0x80 && byte(1) < 0xa0) return {2, byte(1)};
  return {};
}

}  // namespace

std::string printable(std::string_view text, bool several_lines) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string shown;
  shown.reserve(text.size());
  while (!text.empty()) {
    const Control control = control_at(text);
    const bool layout = control.number == '\n' || control.number == '\t';
    if (control.length == 0 || (several_lines && layout)) {
      shown += text.front();
      text.remove_prefix(1);
      continue;
    }
    shown += "\\u00";
    shown += kDigits[control.number >> 4];
    shown += kDigits[control.number & 15];
    text.remove_prefix(control.length);
  }
  return shown;
}

}  // namespace engram
