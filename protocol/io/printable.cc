#include "protocol/io/printable.h"

#include <array>
#include <cstddef>
#include <utility>

namespace engram {
namespace {

void append_hexadecimal(std::string& shown, char32_t number, int digits) {
  for (int i = digits - 1; i >= 0; --i) shown += "0123456789abcdef"[number >> (4 * i) & 15];
}

}  // namespace

Letter first_letter(std::string_view text) {
  const auto byte = [&text](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
  };
  const unsigned lead = byte(0);
  if (lead < 0x80) return {1, lead, true};
  const std::size_t length = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  char32_t code = lead & (0x7fU >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {1, lead, false};
    code = code << 6 | (byte(i) & 0x3f);
  }
  constexpr std::array<char32_t, 5> kLowest = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xd800 && code < 0xe000;
  const bool valid =
      lead >= 0xc2 && lead <= 0xf4 && code >= kLowest[length] && code <= 0x10ffff && !surrogate;
  return valid ? Letter{length, code, true} : Letter{1, lead, false};
}

bool Letter::printable() const {
  if (!valid) return false;
  constexpr std::array<std::pair<char32_t, char32_t>, 7> kControls = {{{0x00, 0x1f},
                                                                       {0x7f, 0x9f},
                                                                       {0x61c, 0x61c},
                                                                       {0x200e, 0x200f},
                                                                       {0x2028, 0x202e},
                                                                       {0x2066, 0x2069},
                                                                       {0xfeff, 0xfeff}}};
  for (const auto& [low, high] : kControls) {
    if (code >= low && code <= high) return false;
  }
  return true;
}

std::string printable(std::string_view text, bool several_lines) {
  std::string shown;
  shown.reserve(text.size());
  while (!text.empty()) {
    const Letter letter = first_letter(text);
    const bool layout = several_lines && (letter.code == '\n' || letter.code == '\t');
    if (letter.printable() || layout) {
      shown += text.substr(0, letter.length);
    } else {
      shown += letter.valid ? "\\u" : "\\x";
      append_hexadecimal(shown, letter.code, letter.valid ? 4 : 2);
    }
    text.remove_prefix(letter.length);
  }
  return shown;
}

}  // namespace engram
