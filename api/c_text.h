// Texts that callers of the C API own.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>

namespace engram::c {

// A copy for engram_free_text. Throws std::bad_alloc if there is no memory.
inline char* new_text(const std::string& text) {
  char* copy = static_cast<char*>(std::malloc(text.size() + 1));
  if (copy == nullptr) throw std::bad_alloc();
  std::memcpy(copy, text.c_str(), text.size() + 1);
  return copy;
}

// Copies at most `capacity` bytes, the closing 0 included; length may be null.
inline void give_text(const std::string& from, char* text, std::size_t capacity,
                      std::size_t* length) {
  if (length != nullptr) *length = from.size();
  if (capacity == 0) return;
  const std::size_t count = std::min(from.size(), capacity - 1);
  std::memcpy(text, from.data(), count);
  text[count] = '\0';
}

}  // namespace engram::c
