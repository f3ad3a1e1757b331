// Texts that callers of the C API own.
#pragma once

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

}  // namespace engram::c
